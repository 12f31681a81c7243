// SPDX-License-Identifier: Apache-2.0
#include "runtime/dds_log.hpp"

#include <memory>
#include <mutex>

#include <fastdds/dds/log/Log.hpp>

#include "runtime/log.hpp"

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

class ToOurs final : public fdds::LogConsumer {
 public:
  void Consume(const fdds::Log::Entry& entry) override {
    const std::string text = entry.message + " (" + entry.context.category + ")";
    logger_.write_every(1.0, level_of(entry.kind), entry.context.category, text);
  }

 private:
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

}  // namespace tandem::runtime
