// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/frame_tree.hpp"

#include <algorithm>
#include <utility>

namespace tandem {
namespace {

constexpr int kMotionSteps = 10;  // times within the window at which moved() looks
constexpr double kLevel = 0.7;    // least cosine of the tilt between two frames that have one plane
constexpr std::size_t kDeepest = 1'000;  // links of a chain, as in tf2; a longer chain is a loop

Eigen::Isometry3d isometry(const Eigen::Quaterniond& q, const Eigen::Vector3d& p) {
  return Eigen::Translation3d(p) * q;
}

bool is_name(std::string_view name) { return !name.empty() && name.size() <= FrameTree::kLongest; }

std::string quoted(std::string_view name) { return "`" + std::string{name} + "`"; }

// Distance in the plane, plus the turn as that of a point 1 m away [m].
double apart(const Pose2& a, const Pose2& b) {
  return (a.position() - b.position()).norm() + std::abs(wrap_angle(a.theta - b.theta));
}

}  // namespace

// A restarted or second sender may have earlier stamps: the history restarts then.
void FrameTree::Link::remember(const FrameLink& link) {
  X_PC = link.X_PC;
  sender = link.sender;
  arrival = link.arrival;
  const double before = std::exchange(time, link.stamp.value_or(link.arrival));
  if (link.stamp.has_value() != stamp.has_value() || time < before) past.clear();
  stamp = link.stamp;
  if (!past.empty() && time < past.back().time + kSpacing) return;
  past.push_back({time, Eigen::Quaterniond{X_PC.linear()}, X_PC.translation()});
  if (past.size() > kSamples) past.pop_front();
}

// Interpolates between samples; constant before the first and after the newest.
Eigen::Isometry3d FrameTree::Link::at(double t) const {
  if (t >= time || past.empty()) return X_PC;
  const auto after =
      std::find_if(past.begin(), past.end(), [t](const Sample& sample) { return sample.time > t; });
  if (after == past.begin()) return isometry(after->q_PC, after->p_PC);
  const Sample& from = *std::prev(after);
  const Sample newest{time, Eigen::Quaterniond{X_PC.linear()}, X_PC.translation()};
  const Sample& to = after == past.end() ? newest : *after;
  const double share = (t - from.time) / (to.time - from.time);
  return isometry(from.q_PC.slerp(share, to.q_PC), from.p_PC + share * (to.p_PC - from.p_PC));
}

// Speed over the last samples [m/s], rotation counted as that of a point 1 m away.
double FrameTree::Link::speed() const {
  if (past.size() < 2) return 0.0;
  const Sample& from = past[past.size() - std::min<std::size_t>(past.size(), 4)];
  const double duration = time - from.time;
  if (!(duration > 0.0)) return 0.0;
  const double turn = from.q_PC.angularDistance(Eigen::Quaterniond{X_PC.linear()});
  return ((X_PC.translation() - from.p_PC).norm() + turn) / duration;
}

LinkFate FrameTree::set_static(const FrameLink& link) { return add(link, true); }
LinkFate FrameTree::set(const FrameLink& link) { return add(link, false); }

LinkFate FrameTree::add(const FrameLink& link, bool is_static) {
  const std::string_view parent = bare_frame(link.parent), child = bare_frame(link.child);
  if (!is_name(parent) || !is_name(child)) return LinkFate::kUnnamed;
  if (parent == child) return LinkFate::kLoop;
  auto known = links_.find(child);
  if (known == links_.end()) {
    if (links_.size() >= kMaxFrames) return LinkFate::kFull;
    known = links_.emplace(child, Link{.parent = std::string{parent}}).first;
    if (!is_static) known->second.arrival = link.arrival;
  }
  Link& old = known->second;
  const bool has_two = old.parent != parent;
  if (has_two) note_parents(known->first, old, link);
  if (!is_static || !old.is_dynamic()) {
    if (has_two) {
      old.past.clear();
      old.parent = parent;
    }
    old.remember(link);
    if (is_static) old.arrival = FramePose::kAlways;
  }
  return has_two ? LinkFate::kTwoParents : LinkFate::kTaken;
}

void FrameTree::note_parents(const std::string& child, const Link& old, const FrameLink& link) {
  two_parents_[child] = {.parent = std::string{bare_frame(link.parent)},
                         .other = old.parent,
                         .sender = link.sender,
                         .other_sender = old.sender,
                         .t = link.arrival};
}

// nullopt for a loop.
std::optional<FrameTree::Chain> FrameTree::chain_of(std::string_view frame) const {
  Chain chain;
  for (auto link = links_.find(frame); link != links_.end();
       link = links_.find(link->second.parent)) {
    if (chain.size() == kDeepest) return std::nullopt;
    chain.push_back(&link->second);
  }
  return chain;
}

std::string_view FrameTree::root_of(const Chain& chain, std::string_view frame) {
  return chain.empty() ? frame : std::string_view{chain.back()->parent};
}

// X_RF in the root R, with each dynamic link as it was `ago` seconds before time `t`; without `t`,
// and for a link without stamps, before its newest value.
Eigen::Isometry3d FrameTree::composed(const Chain& chain, std::optional<double> t, double ago) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (const Link* link : chain) {
    const double newest = t && link->stamp ? *t : link->time;
    X = (link->is_dynamic() ? link->at(newest - ago) : link->X_PC) * X;
  }
  return X;
}

// X_BF of the frame in the base.
Eigen::Isometry3d FrameTree::composed(const Branches& branches, double ago) {
  return composed(branches.down, branches.stamp, ago).inverse() *
         composed(branches.up, branches.stamp, ago);
}

// nullopt if the frames are not connected.
std::optional<FrameTree::Branches> FrameTree::between(std::string_view base,
                                                      std::string_view frame) const {
  base = bare_frame(base);
  frame = bare_frame(frame);
  auto down = chain_of(base), up = chain_of(frame);
  if (!down || !up) return std::nullopt;
  if (base.empty() || root_of(*down, base) != root_of(*up, frame)) return std::nullopt;
  while (!down->empty() && !up->empty() && down->back() == up->back()) {
    down->pop_back();
    up->pop_back();
  }
  Chain moving = *down;
  moving.insert(moving.end(), up->begin(), up->end());
  std::erase_if(moving, [](const Link* link) { return !link->is_dynamic(); });
  const auto stamp = moving.size() > 1 ? common_stamp(moving) : std::nullopt;
  return Branches{std::move(*down), std::move(*up), std::move(moving), stamp};
}

std::optional<FramePose> FrameTree::find(std::string_view base, std::string_view frame,
                                         std::optional<double> stamp) const {
  auto branches = between(base, frame);
  if (!branches) return std::nullopt;
  if (stamp)
    branches->stamp = stamp;
  else if (branches->stamp && first_stamp(branches->moving) - *branches->stamp > kMaxApart)
    return std::nullopt;
  FramePose found{.X_BF = composed(*branches, 0.0)};
  for (const Link* link : branches->moving) {
    found.arrival = std::min(found.arrival, link->arrival);
    if (branches->stamp && link->stamp)
      found.drift += link->speed() * std::max(0.0, *branches->stamp - *link->stamp);
  }
  return found;
}

double FrameTree::moved(std::string_view base, std::string_view frame) const {
  const auto branches = between(base, frame);
  if (!branches || branches->moving.empty()) return 0.0;
  const Eigen::Isometry3d X_BF = composed(*branches, 0.0);
  double in_base = 0.0, in_frame = 0.0;
  for (int step = 1; step <= kMotionSteps; ++step) {
    const Eigen::Isometry3d past = composed(*branches, kMotionWindow * step / kMotionSteps);
    in_base = std::max(in_base, apart(in_plane(X_BF), in_plane(past)));
    in_frame = std::max(in_frame, apart(in_plane(X_BF.inverse()), in_plane(past.inverse())));
  }
  const bool both_level = X_BF.linear()(2, 2) > kLevel;
  return both_level ? std::min(in_base, in_frame) : in_base;
}

// The newest time that all links have reached; nullopt if no link has stamps.
std::optional<double> FrameTree::common_stamp(const Chain& links) {
  std::optional<double> common;
  for (const Link* link : links)
    if (link->stamp) common = std::min(common.value_or(*link->stamp), *link->stamp);
  return common;
}

// The oldest time for which all stamped links still have samples.
double FrameTree::first_stamp(const Chain& links) {
  double first = -FramePose::kAlways;
  for (const Link* link : links)
    if (link->stamp && !link->past.empty()) first = std::max(first, link->past.front().time);
  return first;
}

std::optional<Eigen::Isometry3d> FrameTree::pose(std::string_view base,
                                                 std::string_view frame) const {
  const auto found = find(base, frame);
  return found ? std::optional{found->X_BF} : std::nullopt;
}

bool FrameTree::is_above(std::string_view frame, std::string_view base) const {
  const auto chain = chain_of(bare_frame(base));
  bool moves = false;
  if (chain)
    for (const Link* link : *chain) {
      moves = moves || link->is_dynamic();
      if (moves && link->parent == bare_frame(frame)) return true;
    }
  return false;
}

bool FrameTree::contains(std::string_view frame) const {
  return links_.contains(frame) ||
         std::any_of(links_.begin(), links_.end(),
                     [frame](const auto& link) { return link.second.parent == frame; });
}

std::string FrameTree::why_not(std::string_view base, std::string_view frame) const {
  base = bare_frame(base);
  frame = bare_frame(frame);
  std::string text;
  const auto down = chain_of(base), up = chain_of(frame);
  if (links_.empty())
    text = "no transform has arrived on /tf or /tf_static";
  else if (!contains(base) || !contains(frame))
    text = quoted(contains(base) ? frame : base) + " is not on /tf; frames there: " + listing();
  else if (!down || !up)
    text = "the transforms on /tf form a cycle: " + listing();
  else if (root_of(*down, base) != root_of(*up, frame))
    text =
        "no transform on /tf connects " + quoted(base) + " and " + quoted(frame) + ": " + listing();
  else
    text = "the stamps along the chain " + quoted(base) + " … " + quoted(frame) +
           " are too far apart: check the publishers' clocks";
  if (!two_parents_.empty()) {
    const auto& [child, parents] = *two_parents_.begin();
    text += "; " + quoted(child) + " has two parents, " + quoted(parents.parent) + " and " +
            quoted(parents.other);
  }
  return text;
}

void FrameTree::for_each(const std::function<void(const std::string&, const std::string&, bool,
                                                  const FrameSender&)>& visit) const {
  std::vector<const std::pair<const std::string, Link>*> sorted;
  for (const auto& link : links_) sorted.push_back(&link);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto* a, const auto* b) { return a->first < b->first; });
  for (const auto* link : sorted)
    visit(link->first, link->second.parent, !link->second.is_dynamic(), link->second.sender);
}

std::string FrameTree::listing() const {
  if (links_.empty()) return "none";
  std::string text;
  std::size_t listed = 0;
  for_each([&](const std::string& child, const std::string& parent, bool, const FrameSender&) {
    if (++listed <= kMaxListed) text += (text.empty() ? "" : ", ") + parent + " → " + child;
  });
  if (listed > kMaxListed) text += " and " + std::to_string(listed - kMaxListed) + " more";
  return text;
}

void FrameTree::on_time_jump() {
  for (auto& [child, link] : links_)
    if (link.is_dynamic()) link.arrival = -FramePose::kAlways;
  two_parents_.clear();
}

}  // namespace tandem
