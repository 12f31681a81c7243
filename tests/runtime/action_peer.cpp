// SPDX-License-Identifier: Apache-2.0
// The other process of the tests of actions with rclpy. `action_peer serve`: serves /fibonacci; it
// rejects a negative order, aborts one above 100, and does not let 13 be cancelled. `action_peer
// send ORDER`: sends a goal to it and prints what it is told, a line each; `action_peer cancel
// ORDER` also cancels it at the first feedback. Ends with the goal, or with 0 on SIGTERM.
#include <spdlog/fmt/ranges.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <test_msgs/messages.hpp>
#include <vector>

#include "tandem/runtime/action_client.hpp"
#include "tandem/runtime/action_server.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace {

namespace rt = tandem::rt;
using tandem::test_msgs::action::Fibonacci;

constexpr rt::ActionName<Fibonacci> kAction{"fibonacci"};
constexpr double kPeriod = 0.02;    // [s] from number to number
constexpr double kPatience = 30.0;  // [s]
constexpr int kUnlucky = 13, kTooMuch = 100;

void print(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

class FibonacciServer {
 public:
  explicit FibonacciServer(rt::Node& node)
      : server_{node.create_action_server(
            kAction, {.on_goal =
                          [](const auto& goal) {
                            return goal.order() < 0 ? rt::GoalAnswer::kReject
                                                    : rt::GoalAnswer::kExecute;
                          },
                      .on_cancel = [](const auto& goal) { return goal.goal().order() != kUnlucky; },
                      .on_accepted =
                          [this](const auto& goal) {
                            running_.push_back({goal, {0, 1}});
                          }})},
        timer_{node.create_wall_timer(kPeriod, [this] { advance(); })} {}

 private:
  struct Running {
    rt::ServerGoal<Fibonacci> goal;
    std::vector<std::int32_t> numbers;
  };

  void advance() {
    for (Running& running : running_) advance(running);
    std::erase_if(running_, [](const Running& running) { return !running.goal.is_active(); });
  }

  static void advance(Running& running) {
    const int order = running.goal.goal().order();
    Fibonacci::Result result;
    result.sequence(running.numbers);
    if (running.goal.is_canceling()) return running.goal.canceled(result);
    if (order > kTooMuch) return running.goal.abort(result);
    if (std::ssize(running.numbers) > order) return running.goal.succeed(result);
    running.numbers.push_back(*(running.numbers.end() - 1) + *(running.numbers.end() - 2));
    Fibonacci::Feedback feedback;
    feedback.sequence(running.numbers);
    running.goal.publish_feedback(feedback);
  }

  std::vector<Running> running_;
  rt::ActionServer<Fibonacci> server_;
  rt::Timer timer_;
};

void serve() {
  rt::Node node{"fibonacci_server"};
  const FibonacciServer server{node};
  node.spin();
}

void send(int order, bool cancels) {
  rt::Node node{"fibonacci_client"};
  auto client = node.create_action_client(kAction);
  rt::GoalId id{};
  Fibonacci::Goal goal;
  goal.order(order);
  const auto on_reply = [&](rt::GoalReply reply) {
    print(reply == rt::GoalReply::kAccepted ? "accepted" : "rejected");
    if (reply != rt::GoalReply::kAccepted) node.stop();
  };
  const auto on_feedback = [&](const Fibonacci::Feedback& feedback) {
    print(fmt::format("feedback {}", fmt::join(feedback.sequence(), " ")));
    if (!std::exchange(cancels, false)) return;
    client.cancel(id, [](auto answer) { print(fmt::format("cancel {}", int(answer))); });
  };
  const auto on_result = [&](rt::GoalStatus status, const Fibonacci::Result& result) {
    print(fmt::format("{} {}", name(status), fmt::join(result.sequence(), " ")));
    node.stop();
  };
  id = client.send(goal, {on_reply, on_feedback, on_result}, kPatience);
  node.spin();
}

}  // namespace

int main(int argc, char** argv) try {
  rt::install_signal_handlers();
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "serve")
    serve();
  else if (argc > 2)
    send(std::atoi(argv[2]), mode == "cancel");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "action_peer: %s\n", error.what());
  return 1;
}
