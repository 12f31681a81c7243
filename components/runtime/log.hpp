// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Levels of log lines, in rising order; kOff writes none.
enum class LogLevel { kDebug, kInfo, kWarn, kError, kOff };

/// Source location of a log call. (clang 14 has no std::source_location.)
struct Place {
  const char* file;      ///< path as the compiler was given it
  const char* function;  ///< its name
  unsigned line;         ///< from 1

  /// The place of the call in whose default argument this stands.
  static constexpr Place here(const char* file = __builtin_FILE(),
                              const char* function = __builtin_FUNCTION(),
                              unsigned line = __builtin_LINE()) {
    return {file, function, line};
  }
};

/// A format string, checked against its arguments at compile time, and its source location.
template <class... Args>
struct LogFormat {
  /// Does not compile if `format` does not fit the arguments.
  template <class Text>
  FMT_CONSTEVAL LogFormat(const Text& format, Place at = Place::here())  // implicit, as fmt's own
      : text{format}, place{at} {}

  fmt::format_string<Args...> text;  ///< checked at compile time
  Place place;                       ///< where it is written
};

/// A log event as passed to a Logger::Sink.
struct LogLine {
  LogLevel level;           ///< of this line
  const std::string& text;  ///< valid during the call only
  const Place& place;       ///< valid during the call only
};

/// Sets the lowest level written by loggers that have no own level; initially TANDEM_LOG_LEVEL
/// (debug, info, warn, error, off).
TANDEM_EXPORT void set_log_level(LogLevel level);

/// Whether lines go to stderr.
TANDEM_EXPORT void set_log_to_stderr(bool wanted);

/// Case-insensitive; also accepts "warning" and ROS 2's "fatal". Throws std::invalid_argument for
/// an unknown level.
[[nodiscard]] TANDEM_EXPORT LogLevel log_level_from(std::string_view name);

/// Writes one line per event to stderr: `[level] [time] [node]: text`. Thread-safe.
class TANDEM_EXPORT Logger {
 public:
  /// Takes each line that is written, on the thread that logs.
  using Sink = std::function<void(const LogLine&)>;

  /// `name`: the node's, as it is printed.
  explicit Logger(std::string name);
  ~Logger();
  Logger(Logger&&) noexcept;
  Logger& operator=(Logger&&) noexcept;

  /// Writes a line of this level, formatted by {fmt}.
  template <class... Args>
  void debug(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kDebug, format, std::forward<Args>(args)...);
  }
  /// Writes a line of this level, formatted by {fmt}.
  template <class... Args>
  void info(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kInfo, format, std::forward<Args>(args)...);
  }
  /// Writes a line of this level, formatted by {fmt}.
  template <class... Args>
  void warn(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kWarn, format, std::forward<Args>(args)...);
  }
  /// Writes a line of this level, formatted by {fmt}.
  template <class... Args>
  void error(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kError, format, std::forward<Args>(args)...);
  }

  /// Like warn and error, but at most once per `period` [s] for each format string. The next line
  /// reports how many were suppressed.
  template <class... Args>
  void warn_every(double period, LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log_every(period, LogLevel::kWarn, format, std::forward<Args>(args)...);
  }
  /// As warn_every(), as an error.
  template <class... Args>
  void error_every(double period, LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log_every(period, LogLevel::kError, format, std::forward<Args>(args)...);
  }

  /// Reports a missing input at most once per `period` [s] for each text. Logs a warning, but only
  /// an info in the logger's first 2 s, while the system is still starting.
  template <class... Args>
  void missing_every(double period, LogFormat<std::type_identity_t<Args>...> format,
                     Args&&... args) {
    const auto text = fmt::format(format.text, std::forward<Args>(args)...);
    write_every(period, missing_level(), text, text, format.place);
  }

  /// The name it was given.
  [[nodiscard]] const std::string& name() const;
  /// Whether lines of this level are written.
  [[nodiscard]] bool enabled(LogLevel level) const { return level >= this->level(); }
  /// Lowest level that is written: the logger's own or the process's.
  [[nodiscard]] LogLevel level() const;
  /// Sets the logger's own level; nullopt restores the process's.
  void set_level(std::optional<LogLevel> level);
  /// Additional destination besides stderr, called on the logging thread; it must not log. An empty
  /// sink removes it.
  void set_sink(Sink sink);

  /// Takes the time [s] for what is written once per period from `clock` instead of the steady
  /// clock. Not thread-safe.
  void set_clock(std::function<double()> clock);

  /// Writes a text that is not a format string.
  void write(LogLevel level, const std::string& text, const Place& place = Place::here());
  /// Like write, but at most once per `period` [s] for each `key`.
  void write_every(double period, LogLevel level, std::string_view key, const std::string& text,
                   const Place& place = Place::here());

 private:
  friend class StateLog;

  template <class... Args>
  void log(LogLevel level, const LogFormat<std::type_identity_t<Args>...>& format, Args&&... args) {
    if (enabled(level))
      write(level, fmt::format(format.text, std::forward<Args>(args)...), format.place);
  }
  template <class... Args>
  void log_every(double period, LogLevel level,
                 const LogFormat<std::type_identity_t<Args>...>& format, Args&&... args) {
    const fmt::string_view key = format.text;
    if (enabled(level))
      write_every(period, level, {key.data(), key.size()},
                  fmt::format(format.text, std::forward<Args>(args)...), format.place);
  }

  [[nodiscard]] double now() const;
  [[nodiscard]] LogLevel missing_level() const;

  /// False if a line with this key was written less than `period` [s] ago.
  bool try_write(double period, LogLevel level, std::string_view key, const std::string& text,
                 const Place& place);
  /// Counts a line for the next one with this key, which says how many were suppressed.
  void suppress(std::string_view key);

  struct State;
  std::unique_ptr<State> state_;
};

/// Logs each state of a node, for example why it stands, when it is entered, at most once per
/// period. A state that is entered again within the period is logged when it has lasted for
/// kSettled or the period ends. Not thread-safe.
class TANDEM_EXPORT StateLog {
 public:
  static constexpr double kSettled = 1.0;  ///< [s]

  /// `period` [s]; `log` must outlive it.
  StateLog(Logger& log, double period) : log_{log}, period_{period} {}

  /// Call it repeatedly while the state lasts. States with the same `key` are the same; the text
  /// may differ, for example by a count.
  void enter(LogLevel level, std::string_view key, const std::string& text,
             const Place& place = Place::here());
  /// As enter(), for a missing input, with the level of Logger::missing_every().
  void enter_missing(const std::string& text, const Place& place = Place::here());
  /// The node is in none of the states that are logged.
  void leave();

 private:
  Logger& log_;
  double period_;
  std::optional<std::string> key_;  ///< of the present state
  double entered_ = 0.0;            ///< [s]
  bool is_pending_ = false;         ///< not logged yet
};

}  // namespace tandem::runtime
