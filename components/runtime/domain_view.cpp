// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/domain_view.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/detail/participant_ports.hpp"

namespace tandem::runtime {
namespace {

using EntitiesSinceIron = rmw_dds_common::msg::ParticipantEntitiesInfo;
using EntitiesOfHumble = rmw_dds_common_humble::msg::ParticipantEntitiesInfo;

constexpr QoS kAll{.durability = Durability::kTransientLocal, .depth = 400};

constexpr std::size_t kPrefix = 12, kGuid = 16;  // [bytes]

template <class Iterator>
std::string hex(Iterator bytes, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i, ++bytes) text += fmt::format("{:02x}", *bytes);
  return text;
}

std::string hex(const rtps::GUID_t& guid) {
  return hex(guid.guidPrefix.value, kPrefix) + hex(guid.entityId.value, kGuid - kPrefix);
}

// A participant's last announcement: its nodes and the owner of each endpoint.
struct Announced {
  GraphForm form;
  std::vector<std::string> nodes;
  std::map<std::string, std::string> owner;  // endpoint's GUID → node
};

template <class Info>
std::pair<std::string, Announced> digest(const Info& info, GraphForm form) {
  Announced announced{form, {}, {}};
  for (const auto& entry : info.node_entities_info_seq()) {
    std::string name = NodeName{entry.node_namespace().c_str(), entry.node_name().c_str()}.full();
    if (auto shown = shown_name(name))
      name = *std::move(shown);
    else
      announced.nodes.push_back(name);
    for (const auto* gids : {&entry.reader_gid_seq(), &entry.writer_gid_seq()})
      for (const auto& gid : *gids) announced.owner[hex(gid.data().begin(), kGuid)] = name;
  }
  return {hex(info.gid().data().begin(), kPrefix), std::move(announced)};
}

std::shared_ptr<DdsNode> on_dds(const Node& node) {
  auto core = std::dynamic_pointer_cast<DdsNode>(node.core());
  if (!core) throw std::invalid_argument("a DomainView needs a node on DDS, not on a LocalBus");
  return core;
}

// More than kIdsOfDomain participants on one host use ports of the next domain.
bool borrows_ports(int domain, const std::vector<std::uint32_t>& ports) {
  return std::any_of(ports.begin(), ports.end(), [domain](std::uint32_t port) {
    return participant_id(domain, port).value_or(0) >= kIdsOfDomain;
  });
}

}  // namespace

struct DomainView::State {
  explicit State(std::shared_ptr<DdsNode> node_core)
      : core{std::move(node_core)},
        reader{core->open_reader(
            {"ros_discovery_info", since_iron.dds_name(), kAll},
            [this](const Bytes& bytes, const auto&) { return receive(bytes); })} {}

  // The two formats differ in length, and each codec accepts only its own length.
  bool receive(const Bytes& bytes) {
    EntitiesSinceIron info;
    EntitiesOfHumble old;
    if (since_iron.decode(bytes, &info))
      note(digest(info, GraphForm::kSinceIron));
    else if (humble.decode(bytes, &old))
      note(digest(old, GraphForm::kHumble));
    else
      return false;
    return true;
  }

  void note(std::pair<std::string, Announced> entry) {
    constexpr std::size_t kMaxParticipants = 10'000;
    if (announced.size() < kMaxParticipants || announced.contains(entry.first))
      announced[entry.first] = std::move(entry.second);
  }

  std::shared_ptr<DdsNode> core;
  Codec since_iron{type_ref<EntitiesSinceIron>()}, humble{type_ref<EntitiesOfHumble>()};
  std::map<std::string, Announced> announced;  // by participant
  std::shared_ptr<Reader> reader;
};

DomainView::DomainView(Node& node) : state_{std::make_unique<State>(on_dds(node))} {}

DomainView::~DomainView() { state_->core->close_reader(*state_->reader); }

Domain DomainView::look() const {
  Domain domain;
  domain.id = state_->core->domain();
  domain.malformed = static_cast<int>(state_->reader->malformed());
  std::map<std::string, DomainParticipantInfo> participants;
  for (const auto& known : state_->core->discovery().endpoints()) {
    const KnownEndpoint& endpoint = *known;
    const std::string id = hex(endpoint.guid.guidPrefix.value, kPrefix);
    auto& participant = participants[id];
    participant.id = id;
    participant.ours = state_->core->is_own(endpoint.guid);
    participant.borrows_ports =
        borrows_ports(domain.id, state_->core->discovery().ports(endpoint.guid.guidPrefix));
    const auto announced = state_->announced.find(id);
    std::string node;
    if (announced != state_->announced.end()) {
      participant.form = announced->second.form;
      participant.nodes = announced->second.nodes;
      const auto owner = announced->second.owner.find(hex(endpoint.guid));
      if (owner != announced->second.owner.end()) node = owner->second;
    }
    const bool is_topic = endpoint.topic.starts_with("rt/");
    domain.endpoints.push_back({id, std::move(node),
                                is_topic ? ros_name(endpoint.topic) : endpoint.topic,
                                ros_type(endpoint.type), endpoint.writes, endpoint.policies,
                                type_hash_in(endpoint.user_data), hex(endpoint.guid)});
  }
  for (auto& [id, participant] : participants)
    domain.participants.push_back(std::move(participant));
  return domain;
}

}  // namespace tandem::runtime
