// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: the DDS readers behind one subscription.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

class NodeCore;

[[nodiscard]] PublisherId to_id(const rtps::GUID_t& guid);
[[nodiscard]] rtps::GUID_t to_guid(const PublisherId& id);

/// The readers of one subscription. There is one, unless hear_every_publisher() opens others for
/// publishers that offer less than it requests. A weaker reader also receives what publishers with
/// a stronger one send; each publisher is therefore delivered by the strongest reader that its
/// QoS fits, so that no message arrives twice and reliable publishers are still received reliably.
class ReaderSet {
 public:
  ReaderSet(NodeCore& node, Endpoint endpoint, Reader::Deliver deliver);

  /// `tuned`: lays the node's qos_overrides over a QoS.
  void hear_every_publisher(std::function<QoS(const QoS&)> tuned);
  void close();

  [[nodiscard]] int matched() const;
  [[nodiscard]] PublisherId sender() const { return to_id(route_->sender); }
  [[nodiscard]] std::uint64_t sequence() const { return route_->sequence; }
  [[nodiscard]] long malformed() const;

 private:
  // Shared with the readers, which may run while the set is closed.
  struct Route {
    Reader::Deliver deliver;
    std::vector<Policies> requested;  // of each reader, in the order of opening
    rtps::GUID_t sender;              // of the last sample, and its number
    std::uint64_t sequence = 0;
  };

  void open(const QoS& qos);
  void open_for(const Policies& publisher, const std::function<QoS(const QoS&)>& tuned);

  NodeCore& node_;
  Endpoint endpoint_;
  std::shared_ptr<Route> route_;
  std::vector<std::shared_ptr<Reader>> readers_;
  std::shared_ptr<void> publishers_wanted_;
};

}  // namespace tandem::runtime
