// SPDX-License-Identifier: Apache-2.0
// Lists the participants, nodes and endpoints of a domain for display, from DDS discovery and
// ros_discovery_info.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/node.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Format in which a participant announces its nodes.
enum class GraphForm { kNone, kSinceIron, kHumble };

/// A participant found on the domain.
struct DomainParticipantInfo {
  std::string id;                     ///< GUID prefix, hexadecimal
  bool ours = false;                  ///< of this process
  GraphForm form = GraphForm::kNone;  ///< kNone: not a ROS 2 program
  std::vector<std::string> nodes{};   ///< "/ns/name"
  bool borrows_ports = false;         ///< receives on UDP ports that belong to the next domain
};

/// A reader or writer found on the domain.
struct DomainEndpoint {
  std::string participant;  ///< DomainParticipantInfo::id
  std::string node;         ///< "/ns/name"; empty if no node announced it
  std::string topic, type;  ///< ROS 2's names; services by their DDS names ("rq/…Request")
  bool writes = false;      ///< a writer; false: a reader
  Policies policies;        ///< offered by a writer, requested by a reader
  std::string type_hash;    ///< empty if not announced
  std::string id = {};      ///< GUID, hexadecimal
};

/// What exists on the domain.
struct Domain {
  int id = 0;                                       ///< ROS_DOMAIN_ID
  std::vector<DomainParticipantInfo> participants;  ///< usually one for each process
  std::vector<DomainEndpoint> endpoints;            ///< readers and writers
  int malformed = 0;  ///< samples of ros_discovery_info that failed to decode
};

/// Collects while its node spins. Received samples are validated and their number is bounded.
class TANDEM_EXPORT DomainView {
 public:
  /// Begins to collect; `node` must outlive this. Throws std::invalid_argument for a node on a
  /// LocalBus.
  explicit DomainView(Node& node);
  ~DomainView();
  DomainView(const DomainView&) = delete;
  DomainView& operator=(const DomainView&) = delete;

  /// What has been found so far. Call it on the node's thread.
  [[nodiscard]] Domain look() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::runtime
