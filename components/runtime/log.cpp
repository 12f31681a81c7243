// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/log.hpp"

#include <atomic>
#include <cctype>
#include <cstdlib>
#include <map>
#include <mutex>
#include <stdexcept>

#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_sinks.h>

#include "tandem/config/printable.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {
namespace {

LogLevel level_at_start() {
  const char* name = std::getenv("TANDEM_LOG_LEVEL");
  return name == nullptr || *name == '\0' ? LogLevel::kInfo : log_level_from(name);
}

std::atomic<LogLevel>& least_level() {
  static std::atomic<LogLevel> level{level_at_start()};
  return level;
}

std::atomic<bool>& to_stderr() {
  static std::atomic<bool> wanted{true};
  return wanted;
}

spdlog::level::level_enum to_spdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarn:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      return spdlog::level::off;
  }
  return spdlog::level::off;
}

// One sink for the process, so that lines of different nodes do not mix. Never destroyed: nodes
// may log while the process ends.
const spdlog::sink_ptr& stderr_sink() {
  static const auto* sink = new spdlog::sink_ptr{std::make_shared<spdlog::sinks::stderr_sink_mt>()};
  return *sink;
}

}  // namespace

struct Logger::State {
  static constexpr int kProcessLevel = -1;
  static constexpr double kYouth = 2.0;  // [s]

  struct Throttle {
    double last;  // [s]
    long held_back = 0;
  };

  explicit State(std::string name) : logger{std::move(name), stderr_sink()} {
    logger.set_level(spdlog::level::trace);  // the process's level decides
    logger.set_pattern("[%l] [%E.%f] [%n]: %v");
  }

  std::shared_ptr<const Sink> current_sink() {
    const std::lock_guard lock{mutex};
    return sink;
  }

  std::function<double()> now = steady_seconds;  // [s]
  double start = now();
  spdlog::logger logger;
  std::atomic<int> level = kProcessLevel;  // a LogLevel
  std::mutex mutex;
  std::shared_ptr<const Sink> sink;
  std::map<std::string, Throttle, std::less<>> throttles;
};

void set_log_level(LogLevel level) { least_level() = level; }

void set_log_to_stderr(bool wanted) { to_stderr() = wanted; }

LogLevel log_level_from(std::string_view name) {
  std::string low{name};
  for (char& c : low) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (low == "debug") return LogLevel::kDebug;
  if (low == "info") return LogLevel::kInfo;
  if (low == "warn" || low == "warning") return LogLevel::kWarn;
  if (low == "error") return LogLevel::kError;
  if (low == "off" || low == "fatal") return LogLevel::kOff;
  throw std::invalid_argument("log level '" + std::string{name} +
                              "' is not one of {debug, info, warn, error, fatal, off}");
}

Logger::Logger(std::string name) : state_{std::make_unique<State>(std::move(name))} {}
Logger::~Logger() = default;
Logger::Logger(Logger&&) noexcept = default;
Logger& Logger::operator=(Logger&&) noexcept = default;

const std::string& Logger::name() const { return state_->logger.name(); }

LogLevel Logger::level() const {
  const int own = state_->level;
  return own == State::kProcessLevel ? least_level().load() : static_cast<LogLevel>(own);
}

void Logger::set_level(std::optional<LogLevel> level) {
  state_->level = level ? static_cast<int>(*level) : State::kProcessLevel;
}

void Logger::set_sink(Sink sink) {
  auto next = sink ? std::make_shared<const Sink>(std::move(sink)) : nullptr;
  const std::lock_guard lock{state_->mutex};
  state_->sink = std::move(next);
}

void Logger::set_clock(std::function<double()> clock) {
  state_->now = std::move(clock);
  state_->start = state_->now();
}

double Logger::now() const { return state_->now(); }

LogLevel Logger::missing_level() const {
  return now() < state_->start + State::kYouth ? LogLevel::kInfo : LogLevel::kWarn;
}

// The text may contain received strings (topics, frames, reasons): replace control characters.
void Logger::write(LogLevel level, const std::string& raw, const Place& place) {
  if (!enabled(level)) return;
  const std::string text = printable(raw);
  if (to_stderr()) state_->logger.log(to_spdlog(level), spdlog::string_view_t{text});
  if (const auto sink = state_->current_sink()) (*sink)({level, text, place});
}

void Logger::write_every(double period, LogLevel level, std::string_view key,
                         const std::string& text, const Place& place) {
  if (!try_write(period, level, key, text, place)) suppress(key);
}

bool Logger::try_write(double period, LogLevel level, std::string_view key, const std::string& text,
                       const Place& place) {
  if (!enabled(level)) return true;
  const double now = state_->now();
  long held_back = 0;
  {
    const std::lock_guard lock{state_->mutex};
    const auto [entry, first] =
        state_->throttles.try_emplace(std::string{key}, State::Throttle{now});
    auto& throttle = entry->second;
    if (!first && now < throttle.last + period) return false;
    held_back = std::exchange(throttle.held_back, 0);
    throttle.last = now;
  }
  write(level, held_back > 0 ? fmt::format("{} (and {} times before)", text, held_back) : text,
        place);
  return true;
}

void Logger::suppress(std::string_view key) {
  const std::lock_guard lock{state_->mutex};
  if (const auto entry = state_->throttles.find(key); entry != state_->throttles.end())
    ++entry->second.held_back;
}

void StateLog::enter(LogLevel level, std::string_view key, const std::string& text,
                     const Place& place) {
  if (key == key_ && !is_pending_) return;
  const double now = log_.now();
  if (key != key_) {
    leave();
    key_ = key;
    entered_ = now;
  }
  const double period = now - entered_ >= kSettled ? 0.0 : period_;
  is_pending_ = !log_.try_write(period, level, key, text, place);
}

void StateLog::enter_missing(const std::string& text, const Place& place) {
  enter(log_.missing_level(), text, text, place);
}

void StateLog::leave() {
  if (std::exchange(is_pending_, false)) log_.suppress(*key_);
  key_.reset();
}

}  // namespace tandem::runtime
