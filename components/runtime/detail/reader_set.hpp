// SPDX-License-Identifier: Apache-2.0
// Combines several DDS readers into one subscription. Private to runtime/.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

class DdsNode;

/// The readers of one subscription. There is one, unless accept_every_publisher() opens others for
/// publishers that offer less than it requests. Less demanding readers also match publishers that
/// offer more, so each publisher is delivered only by the most demanding reader that its QoS
/// matches: no message arrives twice, and reliable publishers are still received reliably.
class ReaderSet final : public SubscriptionPort {
 public:
  ReaderSet(DdsNode& node, Endpoint endpoint, Reader::Deliver deliver,
            Reader::DeliverSample deliver_sample);

  /// `tuned` applies the node's qos_overrides to a QoS.
  void accept_every_publisher(std::function<QoS(const QoS&)> tuned);
  void close() override;

  [[nodiscard]] int matched() const override;
  [[nodiscard]] PublisherId sender() const override { return to_id(route_->sender); }
  [[nodiscard]] std::uint64_t sequence() const override { return route_->sequence; }
  [[nodiscard]] long malformed() const override;
  void may_wait(double seconds) override;

 private:
  // Shared with the readers, which may still be running when the set is closed.
  struct Route {
    [[nodiscard]] bool takes(std::size_t index, const rtps::GUID_t& publisher,
                             std::uint64_t number);

    const Discovery& discovery;
    Reader::Deliver deliver;
    Reader::DeliverSample deliver_sample;
    std::vector<Policies> requested;  // one per reader, in the order of opening
    rtps::GUID_t sender;              // sender of the last sample
    std::uint64_t sequence = 0;
    double patience = 0.0;  // how long a message may wait [s]
  };

  void open(const QoS& qos);
  void open_for(const Policies& publisher, const std::function<QoS(const QoS&)>& tuned);

  DdsNode& node_;
  Endpoint endpoint_;
  std::shared_ptr<Route> route_;
  std::vector<std::shared_ptr<Reader>> readers_;
  std::shared_ptr<void> publishers_wanted_;
};

}  // namespace tandem::runtime
