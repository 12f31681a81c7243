// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/clock_source.hpp"

#include <utility>

#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {
namespace {

using rosgraph_msgs::msg::Clock;

}  // namespace

ClockSource::ClockSource(Participant& participant, Endpoint endpoint)
    : participant_{participant},
      endpoint_{std::move(endpoint)},
      reader_{participant,
              endpoint_,
              [this, codec = Codec{type_ref<Clock>()}](const Bytes& bytes, const auto&) {
                Clock clock;
                if (!codec.decode(bytes, &clock)) return false;
                receive(to_nanoseconds(clock.clock()));
                return true;
              },
              {.malformed = [this](std::size_t size) { refuse(endpoint_.malformed_text(size)); },
               .late = [this] { refuse(endpoint_.late_text()); }}} {
  participant_.discovery().add(endpoint_.known(reader_.guid(), false, participant_));
  const auto receiver =
      make_receiver<Clock>([this](const Clock& clock) { receive(to_nanoseconds(clock.clock())); });
  reader_.receive_directly(participant.direct_topic(endpoint_.topic, endpoint_.type),
                           [receiver](const Sample& sample) { return deliver(sample, receiver); });
  // DDS calls with its reader locked, and drain_bytes() locks it: what comes directly, with the
  // topic locked, must not call it.
  reader_.on_arrival(
      [this] {
        const std::lock_guard lock{receiving_};
        (void)reader_.drain_bytes();
      },
      [this] { (void)reader_.drain_samples(); });
}

ClockSource::~ClockSource() { participant_.discovery().remove(reader_.guid()); }

void ClockSource::receive(std::int64_t time) {
  const std::lock_guard lock{mutex_};
  if (time < time_) ++jumps_;
  time_ = time;
  arrival_ = steady_seconds();
  for (auto* follower : followers_) follower->wake_if_due();
}

void ClockSource::refuse(const std::string& what) {
  const std::lock_guard lock{mutex_};
  refused_ = what;
  for (auto* follower : followers_) follower->wake_if_due();
}

ClockFollower::ClockFollower(std::shared_ptr<ClockSource> source, std::function<void()> wake)
    : source_{std::move(source)}, wake_{std::move(wake)} {
  const std::lock_guard lock{source_->mutex_};
  jumps_seen_ = source_->jumps_;
  source_->followers_.push_back(this);
}

ClockFollower::~ClockFollower() {
  const std::lock_guard lock{source_->mutex_};
  std::erase(source_->followers_, this);
}

ClockFollower::Reading ClockFollower::read() {
  const std::lock_guard lock{source_->mutex_};
  is_waiting_ = false;
  const bool jumped_back = std::exchange(jumps_seen_, source_->jumps_) != source_->jumps_;
  return {source_->time_, source_->arrival_, jumped_back, std::exchange(source_->refused_, {})};
}

bool ClockFollower::is_due(double due) {
  const std::lock_guard lock{source_->mutex_};
  is_waiting_ = !has_news(due);
  due_ = due;
  return !is_waiting_;
}

bool ClockFollower::has_news(double due) const {
  return 1e-9 * static_cast<double>(source_->time_) >= due || jumps_seen_ != source_->jumps_ ||
         !source_->refused_.empty();
}

void ClockFollower::wake_if_due() {
  if (!is_waiting_ || !has_news(due_)) return;
  is_waiting_ = false;
  wake_();
}

}  // namespace tandem::runtime
