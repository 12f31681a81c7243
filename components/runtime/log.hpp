// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

namespace tandem::runtime {

enum class LogLevel { kDebug, kInfo, kWarn, kError, kOff };

/// Least level that is written; from TANDEM_LOG_LEVEL (debug, info, warn, error, off) at start.
void set_log_level(LogLevel level);

/// Throws std::invalid_argument for a name that is no level.
[[nodiscard]] LogLevel log_level_from(std::string_view name);

/// Writes one line per event to stderr: `[level] [time] [node]: text`. May be used by any thread.
class Logger {
 public:
  explicit Logger(std::string name);
  ~Logger();
  Logger(Logger&&) noexcept;
  Logger& operator=(Logger&&) noexcept;

  template <class... Args>
  void debug(fmt::format_string<Args...> format, Args&&... args) {
    if (enabled(LogLevel::kDebug))
      write(LogLevel::kDebug, fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void info(fmt::format_string<Args...> format, Args&&... args) {
    write(LogLevel::kInfo, fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void warn(fmt::format_string<Args...> format, Args&&... args) {
    write(LogLevel::kWarn, fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void error(fmt::format_string<Args...> format, Args&&... args) {
    write(LogLevel::kError, fmt::format(format, std::forward<Args>(args)...));
  }

  /// As info, warn, error, but at most once per `period` [s] for one format text; what was held
  /// back is counted and said with the next line.
  template <class... Args>
  void info_every(double period, fmt::format_string<Args...> format, Args&&... args) {
    write_every(period, LogLevel::kInfo, key(format),
                fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void warn_every(double period, fmt::format_string<Args...> format, Args&&... args) {
    write_every(period, LogLevel::kWarn, key(format),
                fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void error_every(double period, fmt::format_string<Args...> format, Args&&... args) {
    write_every(period, LogLevel::kError, key(format),
                fmt::format(format, std::forward<Args>(args)...));
  }

  [[nodiscard]] bool enabled(LogLevel level) const;
  void write(LogLevel level, const std::string& text);
  /// As write, but at most once per `period` [s] for one `key`.
  void write_every(double period, LogLevel level, std::string_view key, const std::string& text);

 private:
  static std::string_view key(fmt::string_view format) { return {format.data(), format.size()}; }

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::runtime
