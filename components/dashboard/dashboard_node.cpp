// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/dashboard_node.hpp"

#include <ctime>
#include <iostream>
#include <span>
#include <utility>
#include <variant>

#include "tandem/dashboard/own_channels.hpp"
#include "tandem/dashboard/user_study/user_study.hpp"
#include "tandem/dashboard/web/page_files.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
template <class... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

std::string_view text_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Makes untrusted text safe for one line of a terminal: printable ASCII only.
std::string printable(std::string text) {
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

// CPU time of this thread [s].
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

foxglove::Request parse(const WebEvent& event) {
  if (event.kind == WebEvent::Kind::kText) return foxglove::parse_text(event.bytes);
  return foxglove::parse_binary(
      {reinterpret_cast<const std::uint8_t*>(event.bytes.data()), event.bytes.size()});
}

}  // namespace

rt::Interface DashboardNode::interface() {
  return PublishRelay::interface() + rt::Interface{.subscribes = {rt::TopicUse::every()},
                                                   .calls = {rt::ServiceUse::every()},
                                                   .other_input = "web clients",
                                                   .other_output = "web clients"};
}

DashboardNode::DashboardNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      web_{params_->web, foxglove::kSubprotocols, page_files(),
           [&node](const std::string& line) { node.log().warn_every(1.0, "{}", printable(line)); }},
      topics_{node,
              web_,
              {driver_channel(node.fully_qualified_name()),
               trial_channel(node.fully_qualified_name())}},
      services_{node, web_, node.fully_qualified_name() + "/take_wheel",
                [this](ClientId client) { return take_wheel(client); }},
      parameters_{node, web_},
      publish_{node, params_->max_age},
      driver_lock_{params_->seat_timeout},
      autonomy_{node} {
  publish_.open_own(
      node.fully_qualified_name() + "/user_test", "tandem.UserTest",
      [this](ClientId client, const auto& bytes) { return save_user_test(client, bytes); });
  publish_.open_own(
      node.fully_qualified_name() + "/begin_trial", "tandem.TrialRequest",
      [this](ClientId client, const auto& bytes) { return begin_trial(client, bytes); });
  looks_ = node.create_wall_timer(kPollPeriod, [this] { look(); });
  start_ticks();
  node.log().info("the page is at {} ; Foxglove and Lichtblick connect to the same address (ws://)",
                  web_.url());
  // The token is printed to the terminal only, not to /rosout. A token from a file is known
  // already.
  if (const auto& token = web_.token(); !token.empty() && params_->web.token_file.empty())
    std::cerr << "    Open it with the token: " << web_.url() << "?token=" << token << std::endl;
}

// A robot spends most of its day without a client, and each tick wakes the processor.
void DashboardNode::start_ticks() {
  ticks_ = node_.create_wall_timer(is_idle_ ? kIdleTick : kTick, [this] { tick(); });
  time_ = is_idle_ ? rt::Timer{} : node_.create_wall_timer(kTimePeriod, [this] {
    for (const ClientId client : clients_) tell_time(client);
    tell_trial();
  });
}

// Each lane has its own time share of a tick; a single event may exceed it.
void DashboardNode::tick() {
  parameters_.begin_beat();
  for (int i = 0; i < kMaxUrgent && serve(Lane::kUrgent); ++i) {
  }
  serve_for(kLastWords, Lane::kLastWords);
  while (serve(Lane::kLeft)) {
  }
  serve(Lane::kJoined);
  serve_for(kUsual, Lane::kUsual);
  topics_.listen_to_next();
  tell_seat();
  const bool is_idle = clients_.empty() && !trial_;
  if (std::exchange(is_idle_, is_idle) != is_idle) start_ticks();
}

void DashboardNode::serve_for(double time, Lane lane) {
  const double end = node_.steady_now() + time;
  while (serve(lane) && node_.steady_now() < end) {
  }
}

// A client's request must not end the process, which may also run the planner and the filter.
bool DashboardNode::serve(Lane lane) {
  const auto event = web_.next(lane);
  if (!event) return false;
  const double begin = processor_time();
  try {
    on_event(*event);
  } catch (const std::exception& error) {
    complain(event->client, error.what());
  }
  web_.charge(event->client, processor_time() - begin);
  return true;
}

void DashboardNode::look() {
  if (!clients_.empty()) look_at_domain();
  topics_.rest();
  told_.clear();
  if (!came_to_.empty()) tell_trial(came_to_);
}

void DashboardNode::look_at_domain() {
  topics_.look(clients_);
  services_.look(clients_);
}

void DashboardNode::on_event(const WebEvent& event) {
  const ClientId client = event.client;
  if (event.kind == WebEvent::Kind::kJoined) return on_join(client);
  if (event.kind == WebEvent::Kind::kLeft) return on_leave(client);
  std::visit(Overloaded{
                 [&](const foxglove::Subscribe& r) { topics_.subscribe(client, r); },
                 [&](const foxglove::Unsubscribe& r) { topics_.unsubscribe(client, r); },
                 [&](const foxglove::Advertise& r) { on_advertise(client, r); },
                 [&](const foxglove::Unadvertise& r) {
                   publish_.unadvertise(client, r);
                   web_.set_urgent(client, publish_.urgent_prefixes(client));
                 },
                 [&](const foxglove::Message& r) { on_message(client, r); },
                 [&](const foxglove::ServiceCall& r) { on_call(client, r); },
                 [&](const foxglove::GetParameters& r) { parameters_.get(client, r); },
                 [&](const foxglove::SetParameters& r) { on_set(client, r); },
                 [&](const foxglove::SubscribeParameters& r) { parameters_.subscribe(client, r); },
                 [&](const foxglove::Malformed& r) { complain(client, r.reason); },
             },
             parse(event));
}

void DashboardNode::on_join(ClientId client) {
  if (clients_.empty()) look_at_domain();  // nobody has looked since the last client left
  clients_.insert(client);
  const auto session = std::to_string(rt::system_nanoseconds());
  web_.send(client,
            {true, foxglove::server_info("Tandem" + node_.fully_qualified_name(), session)});
  tell_time(client);  // before any timestamped message
  topics_.announce_all(client);
  services_.announce_all(client);
  told_.clear();
  node_.log().info("web client {} connected ({} in total)", client, clients_.size());
}

void DashboardNode::tell_time(ClientId client) {
  const auto stamp = node_.stamp();
  const auto now = static_cast<std::uint64_t>(stamp.sec()) * 1'000'000'000 + stamp.nanosec();
  web_.send(client, {false, foxglove::time(now)});
}

void DashboardNode::on_leave(ClientId client) {
  if (driver_lock_.driver(node_.steady_now()) == client) publish_.release_stick();
  driver_lock_.leave(client);
  autonomy_.on_leave(client);
  clients_.erase(client);
  topics_.forget(client);
  services_.forget(client);
  parameters_.forget(client);
  refused_.erase(client);
  publish_.forget(client);
  told_.clear();
  node_.log().info("web client {} disconnected ({} left)", client, clients_.size());
}

void DashboardNode::on_advertise(ClientId client, const foxglove::Advertise& request) {
  const auto complaint = publish_.advertise(client, request);
  web_.set_urgent(client, publish_.urgent_prefixes(client));
  if (!complaint.empty()) complain(client, complaint);
}

void DashboardNode::on_message(ClientId client, const foxglove::Message& message) {
  const double now = node_.steady_now();
  const auto outcome =
      publish_.publish(client, message, [&] { return driver_lock_.drive(client, now); });
  if (outcome == PublishRelay::Outcome::kPublished) return;
  constexpr double kPeriod = 0.5;  // [s] a refused stick is sent 20 times a second
  if (const auto last = refused_.find(client);
      last != refused_.end() && now - last->second < kPeriod)
    return;
  refused_[client] = now;
  complain(client, PublishRelay::text(outcome));
}

void DashboardNode::on_call(ClientId client, const foxglove::ServiceCall& call) {
  if (!services_.only_reads(call.service) && !driver_lock_.may_write(client, node_.steady_now()))
    return web_.send(client, {true, foxglove::call_failure(call, "someone else is driving")});
  autonomy_.on_call(client, services_.name(call.service), call.payload);
  services_.call(client, call);
}

void DashboardNode::on_set(ClientId client, const foxglove::SetParameters& request) {
  if (driver_lock_.may_write(client, node_.steady_now()))
    parameters_.set(client, request);
  else
    complain(client, "someone else is driving");
}

std_srvs::srv::Trigger::Response DashboardNode::take_wheel(ClientId client) {
  const double now = node_.steady_now();
  const auto before = driver_lock_.driver(now);
  if (before && *before != client) {
    publish_.release_stick();
    complain(*before, "someone else has taken the wheel");
  }
  driver_lock_.take(client, now);
  std_srvs::srv::Trigger::Response response;
  response.success(true);
  response.message("you are driving");
  return response;
}

PublishRelay::Outcome DashboardNode::save_user_test(ClientId client,
                                                    const std::vector<std::uint8_t>& bytes) {
  const double now = node_.steady_now();
  if (now - saved_ < kSavePeriod) {
    complain(client, "not saved: a user test was saved a moment ago");
    return PublishRelay::Outcome::kPublished;
  }
  saved_ = now;
  try {
    const auto test = parse_user_study(text_of(bytes));
    const auto path = save(test, params_->user_tests);
    node_.log().info("user test saved: {}", path.string());
    web_.send(client, {true, foxglove::status(foxglove::Level::kInfo,
                                              "user test saved: " + path.string())});
    return PublishRelay::Outcome::kPublished;
  } catch (const std::invalid_argument& error) {
    complain(client, error.what());
    return PublishRelay::Outcome::kMalformed;
  } catch (const std::runtime_error& error) {
    complain(client, error.what());
    return PublishRelay::Outcome::kPublished;  // the message itself was valid
  }
}

PublishRelay::Outcome DashboardNode::begin_trial(ClientId client,
                                                 const std::vector<std::uint8_t>& bytes) {
  const double now = node_.steady_now();
  if (!driver_lock_.may_write(client, now)) return PublishRelay::Outcome::kOtherDrives;
  if (now - trial_began_ < kTrialPeriod) {
    complain(client, "trial not started: another one started a moment ago");
    return PublishRelay::Outcome::kPublished;
  }
  try {
    const TrialRequest request = parse_trial_request(text_of(bytes));
    trial_began_ = now;
    trial_ = std::make_unique<TrialRecorder>(node_, params_->input, request);
    came_to_.clear();
    return PublishRelay::Outcome::kPublished;
  } catch (const std::invalid_argument& error) {
    complain(client, error.what());
    return PublishRelay::Outcome::kMalformed;
  }
}

void DashboardNode::tell_trial() {
  if (!trial_) return;
  const std::string state = trial_->trial().state();
  tell_trial(state);
  if (!trial_->trial().over()) return;
  trial_.reset();
  came_to_ = state;
}

// Sent to all clients, because a page that reconnects is a new client.
void DashboardNode::tell_trial(const std::string& state) {
  for (const ClientId client : clients_) topics_.send_own(client, kTrialChannel, state);
}

// Reports the driver to each client from that client's view; on changes and with every look.
void DashboardNode::tell_seat() {
  const auto driver = driver_lock_.driver(node_.steady_now());
  const std::string state =
      std::to_string(driver.value_or(0)) + "/" + std::to_string(clients_.size());
  if (state == told_) return;
  told_ = state;
  for (const ClientId client : clients_) {
    const char* who = !driver ? "nobody" : *driver == client ? "you" : "other";
    topics_.send_own(client, kSeatChannel,
                     foxglove::json{{"driver", who}, {"clients", clients_.size()}}.dump());
  }
}

void DashboardNode::complain(ClientId client, const std::string& what) {
  node_.log().warn_every(1.0, "web client {}: {}", client, printable(what));
  web_.answer(client, {true, foxglove::status(foxglove::Level::kWarning, what)});
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::DashboardNode, "dashboard")
