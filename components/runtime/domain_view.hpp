// SPDX-License-Identifier: Apache-2.0
// In: discovery and ros_discovery_info. Out: who is on the domain, for people to look at.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/node.hpp"

namespace tandem::runtime {

/// What a participant says of its nodes.
enum class GraphForm { kNone, kSinceIron, kHumble };

struct DomainParticipantInfo {
  std::string id;  ///< GUID prefix, hexadecimal
  bool ours = false;
  GraphForm form = GraphForm::kNone;  ///< kNone: a DDS program that is no ROS 2 node
  std::vector<std::string> nodes{};   ///< "/ns/name"
};

struct DomainEndpoint {
  std::string participant;  ///< its id
  std::string node;         ///< "/ns/name"; empty if nobody claims it
  std::string topic, type;  ///< ROS 2's names; services by their DDS names ("rq/…Request")
  bool writes = false;
  Policies policies;
  std::string type_hash;  ///< empty: none told
  std::string id = {};    ///< GUID, hexadecimal
};

struct Domain {
  std::vector<DomainParticipantInfo> participants;
  std::vector<DomainEndpoint> endpoints;
  int malformed = 0;  ///< samples of ros_discovery_info that were none
};

/// Collects while its node spins. Samples of others are bounded and never trusted.
class DomainView {
 public:
  explicit DomainView(Node& node);
  ~DomainView();
  DomainView(const DomainView&) = delete;
  DomainView& operator=(const DomainView&) = delete;

  [[nodiscard]] Domain look() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::runtime
