// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/dds_log.hpp"

#include <memory>
#include <mutex>

#include <fastdds/dds/log/Log.hpp>

#include "tandem/runtime/log.hpp"

namespace tandem::runtime {
namespace {

namespace fdds = eprosima::fastdds::dds;

LogLevel level_of(fdds::Log::Kind kind) {
  switch (kind) {
    case fdds::Log::Kind::Error:
      return LogLevel::kError;
    case fdds::Log::Kind::Warning:
      return LogLevel::kWarn;
    case fdds::Log::Kind::Info:
      return LogLevel::kDebug;
  }
  return LogLevel::kError;
}

// The first error since the oldest living DdsErrors was constructed.
struct FirstError {
  std::mutex mutex;
  int awaited = 0;  // number of living DdsErrors
  std::string text;
};

FirstError& first_error() {
  static FirstError error;
  return error;
}

class ToOurs final : public fdds::LogConsumer {
 public:
  void Consume(const fdds::Log::Entry& entry) override {
    const std::string text = entry.message + " (" + entry.context.category + ")";
    if (entry.kind == fdds::Log::Kind::Error) note(text);
    logger_.write_every(1.0, level_of(entry.kind), entry.context.category, text);
  }

 private:
  static void note(const std::string& text) {
    const std::lock_guard lock{first_error().mutex};
    if (first_error().awaited > 0 && first_error().text.empty()) first_error().text = text;
  }

  Logger logger_{"dds"};
};

}  // namespace

void redirect_dds_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    fdds::Log::ClearConsumers();
    fdds::Log::RegisterConsumer(std::make_unique<ToOurs>());
  });
}

DdsErrors::DdsErrors() {
  const std::lock_guard lock{first_error().mutex};
  if (first_error().awaited++ == 0) first_error().text.clear();
}

DdsErrors::~DdsErrors() {
  const std::lock_guard lock{first_error().mutex};
  --first_error().awaited;
}

std::string DdsErrors::first() const {
  fdds::Log::Flush();
  const std::lock_guard lock{first_error().mutex};
  return first_error().text;
}

}  // namespace tandem::runtime
