// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/progress_bar.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

constexpr std::size_t kBar = 24;    // characters
constexpr double kLogEvery = 10.0;  // [s] between lines if not on a terminal

std::string duration(double seconds) {
  const auto s = static_cast<long>(seconds + 0.5);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
}

}  // namespace

ProgressBar::ProgressBar(std::size_t all, std::size_t before, std::string unit)
    : all_{all},
      before_{before},
      unit_{std::move(unit)},
      terminal_{isatty(STDERR_FILENO) == 1},
      start_{runtime::steady_seconds()},
      next_{start_} {}

void ProgressBar::step(const std::string& note) {
  ++now_;
  const double t = runtime::steady_seconds();
  const bool last = before_ + now_ == all_;
  if (!last && t < next_) return;
  next_ = t + (terminal_ ? 0.1 : kLogEvery);
  std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", line(t, note).c_str());
  if (last && terminal_) std::fputc('\n', stderr);
}

void ProgressBar::clear() const {
  if (terminal_) std::fputs("\r\033[K", stderr);
}

std::string ProgressBar::line(double t, const std::string& note) const {
  const std::size_t done = before_ + now_;
  const double left = (t - start_) / static_cast<double>(now_) * static_cast<double>(all_ - done);
  const std::size_t filled = kBar * done / all_;
  return fmt::format("[{}{}] {} of {} {}, {}, {}", std::string(filled, '#'),
                     std::string(kBar - filled, '.'), done, all_, unit_, note,
                     done == all_ ? duration(t - start_) : duration(left) + " left");
}

}  // namespace tandem
