// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/guarded_transport.hpp"

#include <array>
#include <cstring>
#include <mutex>

#include "tandem/runtime/detail/dds_settings.hpp"
#include "tandem/runtime/detail/participant_guard.hpp"
#include "tandem/runtime/detail/wire_guard.hpp"
#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/time.hpp"
#if TANDEM_FASTDDS_3
#include <fastdds/rtps/transport/ChainingTransport.hpp>
#include <fastdds/rtps/transport/SenderResource.hpp>
#include <fastdds/rtps/transport/UDPTransportDescriptor.hpp>
#else
#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/UDPTransportDescriptor.h>
#endif

namespace tandem::runtime {
namespace {

namespace transport = eprosima::fastdds::rtps;

using Listening = std::function<void(std::uint32_t port)>;

// The last four bytes of the locator, which hold an IPv4 address.
std::uint32_t source_of(const rtps::Locator_t& locator) {
  std::uint32_t address = 0;
  std::memcpy(&address, locator.address + sizeof locator.address - sizeof address, sizeof address);
  return address;
}

class GuardedTransport final : public transport::ChainingTransport {
 public:
  GuardedTransport(const transport::ChainingTransportDescriptor& descriptor, WireGuard& of_process,
                   Listening listening)
      : ChainingTransport{descriptor},
        guard_{of_process, !variable(kServersVariable).empty()},
        listening_{std::move(listening)} {}

  transport::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }

  bool OpenInputChannel(const rtps::Locator_t& locator,
                        transport::TransportReceiverInterface* receiver,
                        std::uint32_t max_size) override {
    const bool open = ChainingTransport::OpenInputChannel(locator, receiver, max_size);
    if (open) listening_(locator.port);
    return open;
  }

#if TANDEM_FASTDDS_3
  bool send(rtps::SenderResource* below, const std::vector<rtps::NetworkBuffer>& buffers,
            std::uint32_t size, rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
            const std::chrono::steady_clock::time_point& deadline) override {
    note_sent(buffers);
    return below->send(buffers, size, first, last, deadline);
  }
#else
  bool send(rtps::SenderResource* below, const rtps::octet* data, std::uint32_t size,
            rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
            const std::chrono::steady_clock::time_point& deadline) override {
    guard_.sent({data, size}, steady_seconds());
    return below->send(data, size, first, last, deadline);
  }
#endif

  void receive(transport::TransportReceiverInterface* above, const rtps::octet* data,
               std::uint32_t size, const rtps::Locator_t& to,
               const rtps::Locator_t& from) override {
    // The buffer belongs to the transport below; a chained transport may modify it.
    const std::span datagram{const_cast<rtps::octet*>(data), size};
    const double now = steady_seconds();
    const std::uint64_t source = std::uint64_t{source_of(from)} << 32 | from.port;
    if (const auto goodbye = guard_.goodbye_before(datagram, source, now); !goodbye.empty())
      above->OnDataReceived(goodbye.data(), static_cast<std::uint32_t>(goodbye.size()), to, from);
    if (!guard_.admits(datagram, source_of(from), now)) return;
    // Serialize announcements: while Fast DDS 2.9.1 authenticates a participant, an announcement
    // handled by another thread changes the data being read, and the two may never match.
    std::unique_lock lock{announcements_, std::defer_lock};
    if (announces_participant({data, size})) lock.lock();
    above->OnDataReceived(data, size, to, from);
  }

 private:
#if TANDEM_FASTDDS_3
  // Joins the buffers of a datagram. Only acknowledgements matter, and those are short; longer
  // datagrams are ignored.
  void note_sent(const std::vector<rtps::NetworkBuffer>& buffers) {
    std::array<std::uint8_t, 1500> joined;
    std::size_t size = 0;
    for (const auto& buffer : buffers) {
      if (size + buffer.size > joined.size()) return;
      std::memcpy(joined.data() + size, buffer.buffer, buffer.size);
      size += buffer.size;
    }
    guard_.sent({joined.data(), size}, steady_seconds());
  }
#endif

  ParticipantGuard guard_;
  Listening listening_;
  static inline std::mutex announcements_;  // shared by all transports of the process
};

struct GuardedDescriptor final : transport::ChainingTransportDescriptor {
  GuardedDescriptor(std::shared_ptr<TransportDescriptor> below, WireGuard& of_process,
                    Listening on_listening)
      : ChainingTransportDescriptor{std::move(below)},
        guard{of_process},
        listening{std::move(on_listening)} {}

  transport::TransportInterface* create_transport() const override {
    return new GuardedTransport{*this, guard, listening};  // Fast DDS owns it
  }

  WireGuard& guard;
  Listening listening;
};

}  // namespace

WireGuard& process_guard() {
  static WireGuard guard{{.sample_size = largest_sample()}};
  return guard;
}

std::shared_ptr<TransportDescriptor> guarded(const std::shared_ptr<TransportDescriptor>& transport,
                                             Listening listening) {
  if (dynamic_cast<transport::UDPTransportDescriptor*>(transport.get()) == nullptr) return nullptr;
  return std::make_shared<GuardedDescriptor>(transport, process_guard(), std::move(listening));
}

}  // namespace tandem::runtime
