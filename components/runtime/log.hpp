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

namespace tandem::runtime {

enum class LogLevel { kDebug, kInfo, kWarn, kError, kOff };

/// Where in the sources a line was logged. (clang 14 has no std::source_location.)
struct Place {
  const char* file;
  const char* function;
  unsigned line;

  static constexpr Place here(const char* file = __builtin_FILE(),
                              const char* function = __builtin_FUNCTION(),
                              unsigned line = __builtin_LINE()) {
    return {file, function, line};
  }
};

/// A format text, checked against its arguments, and where it stands.
template <class... Args>
struct LogFormat {
  template <class Text>
  FMT_CONSTEVAL LogFormat(const Text& format, Place at = Place::here())  // implicit, as fmt's own
      : text{format}, place{at} {}

  fmt::format_string<Args...> text;
  Place place;
};

/// One event as it goes to other places than stderr.
struct LogLine {
  LogLevel level;
  const std::string& text;
  const Place& place;
};

/// Least level that is written by loggers without a level of their own; from TANDEM_LOG_LEVEL
/// (debug, info, warn, error, off) at start.
void set_log_level(LogLevel level);

/// Whether lines go to stderr.
void set_log_to_stderr(bool wanted);

/// In capitals or not; "warning" and ROS 2's "fatal" too, of which there is nothing here. Throws
/// std::invalid_argument for a name that is no level.
[[nodiscard]] LogLevel log_level_from(std::string_view name);

/// Writes one line per event to stderr: `[level] [time] [node]: text`. May be used by any thread.
class Logger {
 public:
  using Sink = std::function<void(const LogLine&)>;

  explicit Logger(std::string name);
  ~Logger();
  Logger(Logger&&) noexcept;
  Logger& operator=(Logger&&) noexcept;

  template <class... Args>
  void debug(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kDebug, format, std::forward<Args>(args)...);
  }
  template <class... Args>
  void info(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kInfo, format, std::forward<Args>(args)...);
  }
  template <class... Args>
  void warn(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kWarn, format, std::forward<Args>(args)...);
  }
  template <class... Args>
  void error(LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log(LogLevel::kError, format, std::forward<Args>(args)...);
  }

  /// As warn, error, but at most once per `period` [s] for one format text; what was held
  /// back is counted and said with the next line.
  template <class... Args>
  void warn_every(double period, LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log_every(period, LogLevel::kWarn, format, std::forward<Args>(args)...);
  }
  template <class... Args>
  void error_every(double period, LogFormat<std::type_identity_t<Args>...> format, Args&&... args) {
    log_every(period, LogLevel::kError, format, std::forward<Args>(args)...);
  }

  /// Something that is needed is not there: at most once per `period` [s] for one text. A warning,
  /// but an info in the logger's first 2 s, when it is most likely on its way.
  template <class... Args>
  void missing_every(double period, LogFormat<std::type_identity_t<Args>...> format,
                     Args&&... args) {
    const auto text = fmt::format(format.text, std::forward<Args>(args)...);
    write_every(period, is_young() ? LogLevel::kInfo : LogLevel::kWarn, text, text, format.place);
  }

  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] bool enabled(LogLevel level) const { return level >= this->level(); }
  /// Least level that is written: its own or the process's.
  [[nodiscard]] LogLevel level() const;
  /// Its own level; none: the process's again.
  void set_level(std::optional<LogLevel> level);
  /// Where lines go beside stderr, on whatever thread logs. It must not log. Empty: nowhere.
  void set_sink(Sink sink);

  void write(LogLevel level, const std::string& text, const Place& place = Place::here());
  /// As write, but at most once per `period` [s] for one `key`.
  void write_every(double period, LogLevel level, std::string_view key, const std::string& text,
                   const Place& place = Place::here());

 private:
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

  [[nodiscard]] bool is_young() const;

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::runtime
