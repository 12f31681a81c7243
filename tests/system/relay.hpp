// SPDX-License-Identifier: Apache-2.0
// Simulates a bad network for one topic: forwards what is published under another name, with
// faults.
#pragma once

#include <deque>
#include <functional>
#include <random>
#include <string>

#include "support/slow_motion.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem::test {

/// Subscribes to `<name>_raw` and publishes `<name>`. Forwards everything until a fault is set.
template <class M>
class Relay {
 public:
  Relay(rt::Node& node, const rt::Topic<M>& topic)
      : raw_{std::string{topic.name} + "_raw"},
        out_{node.create_publisher(topic)},
        in_{node.create_subscription(rt::Topic<M>{raw_.c_str(), topic.qos},
                                     [this](const M& msg) {
                                       last_ = msg;
                                       take_(msg);
                                     })},
        flush_{node.create_wall_timer(0.002, [this] { flush(); })} {
    pass();
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Arguments for the publisher's process.
  [[nodiscard]] std::vector<std::string> remapping() const {
    const std::string name = raw_.substr(0, raw_.size() - 4);
    return {"--ros-args", "-r", name + ":=" + raw_};
  }

  void pass() {
    late_.clear();
    take_ = [this](const M& msg) { out_.publish(msg); };
  }
  void drop() {
    take_ = [](const M&) {};
  }
  void lose(double share) {
    take_ = [this, share](const M& msg) {
      if (unit_(random_) >= share) out_.publish(msg);
    };
  }
  void repeat(int times) {
    take_ = [this, times](const M& msg) {
      for (int i = 0; i < times; ++i) out_.publish(msg);
    };
  }
  /// Simulates a second publisher: after each message, also publishes what `spoil` makes of it.
  void intrude(std::function<void(M&)> spoil) {
    take_ = [this, spoil](const M& msg) {
      out_.publish(msg);
      M other = msg;
      spoil(other);
      out_.publish(other);
    };
  }
  /// Delays messages by `least` to `most` seconds of simulated time, so that they can be reordered.
  void delay(double least, double most) {
    take_ = [this, least, most](const M& msg) {
      const double delay = least + unit_(random_) * (most - least);
      late_.push_back({rt::steady_seconds() + delay / kSpeed, msg});
    };
  }
  /// Publishes once the last message as modified by `spoil`.
  void say_again(const std::function<void(M&)>& spoil) {
    M other = last_;
    spoil(other);
    out_.publish(other);
  }
  /// Publishes each message as modified by `spoil`.
  void spoil(std::function<void(M&)> spoil) {
    take_ = [this, spoil](const M& msg) {
      M bad = msg;
      spoil(bad);
      out_.publish(bad);
    };
  }

 private:
  struct Late {
    double due;  // [s] steady clock
    M msg;
  };

  void flush() {
    const double now = rt::steady_seconds();
    for (auto it = late_.begin(); it != late_.end();) {
      if (it->due > now) {
        ++it;
        continue;
      }
      out_.publish(it->msg);
      it = late_.erase(it);
    }
  }

  std::string raw_;
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> unit_{0.0, 1.0};
  std::function<void(const M&)> take_;
  M last_;
  std::deque<Late> late_;
  rt::Publisher<M> out_;
  rt::Subscription in_;
  rt::Timer flush_;
};

}  // namespace tandem::test
