// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/local_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace tandem {
namespace {

constexpr double kFollow = 2.0;   // [m] step in which the window follows the sensor
constexpr float kUnsure = -0.1F;  // log-odds of a voxel covered only by the outline
constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr double kInside = 0.001;  // [m] a return lies on the surface, the obstacle behind it

// Maximum number of rays of a look that clear space, and of voxels cleared. A camera facing a wall
// needs half of that; a cloud of noise would take minutes, during which no message is handled.
// Returns beyond the limit still mark obstacles.
constexpr std::size_t kMaxWays = 30'000, kMaxFree = 1'000'000;

// Poses farther apart than this are a jump; the ground between them was not swept [m].
constexpr double kJump = 1.0;

// Voxels are removed this long [s] before they time out: the time to publish the map and for the
// robot to slow down.
constexpr double kEarly = 1.0;

// Number of searches for old voxels per timeout.
constexpr double kLooksForOld = 60.0;

const LocalMapParams& checked(const LocalMapParams& params) {
  check(params);
  if (!(params.point_cloud_min_z < params.point_cloud_max_z))
    throw std::invalid_argument("point_cloud_min_z must be below point_cloud_max_z");
  if (!(params.min_range < params.max_range))
    throw std::invalid_argument("min_range must be below max_range");
  if (octomap::logodds(params.hit) + octomap::logodds(params.clamp_min) <= 0.0F)
    throw std::invalid_argument(
        "hit must be above 1 - clamp_min, so that a single return marks an obstacle");
  return params;
}

octomap::point3d to_octomap(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

using Node = octomap::OcTreeNode;

bool has_other_child(const octomap::OcTree& tree, const Node* node, unsigned child) {
  for (unsigned i = 0; i < 8; ++i)
    if (i != child && tree.nodeChildExists(node, i)) return true;
  return false;
}

// Turns a node whose single child is a leaf into a leaf. OctoMap frees a node's child table only
// when it prunes eight equal children.
void drop_only_child(octomap::OcTree& tree, Node* node, unsigned child) {
  const float value = tree.getNodeChild(node, child)->getLogOdds();
  for (unsigned i = 0; i < 8; ++i)
    if (i != child) tree.createNodeChild(node, i)->setLogOdds(value);
  tree.pruneNode(node);
}

// Replaces OcTree::deleteNode, which in OctoMap 1.9 fails an assertion when a node loses its last
// child.
void erase_voxel(octomap::OcTree& tree, const octomap::OcTreeKey& key) {
  const unsigned depth = tree.getTreeDepth();
  const auto child_at = [&](unsigned level) {
    return octomap::computeChildIdx(key, static_cast<int>(depth - 1 - level));
  };
  std::array<Node*, 16> path{tree.getRoot()};
  for (unsigned level = 0; level < depth; ++level) {
    if (path[level] == nullptr || !tree.nodeChildExists(path[level], child_at(level))) return;
    if (level + 1 < depth) path[level + 1] = tree.getNodeChild(path[level], child_at(level));
  }
  for (unsigned level = depth; level-- > 0;) {
    if (has_other_child(tree, path[level], child_at(level)))
      return tree.deleteNodeChild(path[level], child_at(level));
    drop_only_child(tree, path[level], child_at(level));
  }
  tree.clear();
}

octomap::OcTree empty_tree(const LocalMapParams& params) {
  octomap::OcTree tree(params.resolution);
  tree.setProbHit(params.hit);
  tree.setProbMiss(params.miss);
  tree.setClampingThresMin(params.clamp_min);
  tree.setClampingThresMax(params.clamp_max);
  return tree;
}

}  // namespace

bool LocalMap::Box::contains(const octomap::OcTreeKey& key) const {
  for (unsigned axis = 0; axis < 3; ++axis)
    if (key[axis] < low[axis] || key[axis] > high[axis]) return false;
  return true;
}

LocalMap::LocalMap(const LocalMapParams& params)
    : params_{checked(params)},
      tree_{empty_tree(params_)},
      window_{box_around(Eigen::Vector3d::Zero())},
      p_MC_{Eigen::Vector3d::Zero()} {}

bool LocalMap::insert(std::span<const Look> looks, double t) {
  for (const auto& [echoes, X_MS] : looks)
    if (!X_MS.matrix().allFinite() || X_MS.translation().cwiseAbs().maxCoeff() > farthest())
      return false;
  if (looks.empty()) return true;
  follow(looks.back().X_MS.translation());
  free_.clear();
  occupied_.clear();
  for (const Look& each : looks) look(each);
  for (const octomap::OcTreeKey& key : occupied_) {
    tree_.updateNode(key, true, true);
    auto [covered, is_settled] = covered_.at(key);
    covered = t;
    is_settled = false;
  }
  for (const octomap::OcTreeKey& key : free_)
    if (occupied_.count(key) == 0) set_free(key, t);
  forget_old(t);
  return true;
}

// Once its log-odds are at their limit, another beam changes nothing: most voxels of a scan need no
// look into the tree.
void LocalMap::set_free(const octomap::OcTreeKey& key, double t) {
  auto [covered, is_settled] = covered_.at(key);
  covered = t;
  if (is_settled) return;
  const Node* node = tree_.updateNode(key, false, true);
  is_settled = node->getLogOdds() <= tree_.getClampingThresMinLog();
}

// Adds the look's returns to `occupied_` and the voxels along its beams to `free_`.
void LocalMap::look(const Look& look) {
  const auto& [echoes, X_MS] = look;
  const Eigen::Vector3d p_MS = X_MS.translation();
  ends_.clear();
  for (const Eigen::Vector3d& p_SQ : echoes.p_SQ) {
    const double range = p_SQ.norm();
    if (!(range >= params_.min_range) || range == 0.0) continue;  // also rejects NaN
    const Eigen::Vector3d p_MQ = X_MS * (p_SQ * (1.0 + kInside / range));
    octomap::OcTreeKey key;
    const bool is_high_enough = p_MQ.z() >= params_.point_cloud_min_z;
    const bool is_low_enough = p_MQ.z() <= params_.point_cloud_max_z;
    if (range <= params_.max_range && is_high_enough && is_low_enough &&
        tree_.coordToKeyChecked(to_octomap(p_MQ), key) && window_.contains(key))
      occupied_.insert(key);
    clear_way(p_MS, range <= params_.max_range ? p_MQ : X_MS * (p_SQ * params_.max_range / range));
  }
  for (const Eigen::Vector3d& p_SFree : echoes.p_SFree)
    clear_way(p_MS, X_MS * (p_SFree * std::min(1.0, params_.max_range / p_SFree.norm())));
}

// Maximum coordinate for which a window around the point still has OctoMap keys.
double LocalMap::farthest() const {
  constexpr double kKeys = 32767.0;
  return kKeys * params_.resolution - std::max(params_.window, params_.max_range) - kFollow;
}

void LocalMap::clear() {
  tree_.clear();
  covered_.clear();
  stood_.reset();
}

void LocalMap::stand(const Footprint& outline, const Pose2& X_MB, double z, double t) {
  if (!is_finite(X_MB) || X_MB.position().cwiseAbs().maxCoeff() > farthest() ||
      std::abs(z) > farthest())
    return;
  const Stand last = stood_.value_or(Stand{X_MB, t});
  const double turn = wrap_angle(X_MB.theta - last.X_MB.theta);
  const Eigen::Vector2d way = X_MB.position() - last.X_MB.position();
  const double travel = way.norm() + circumradius(outline) * std::abs(turn);
  const bool is_fresh = t >= last.t && t - last.t < params_.coverage_timeout / kLooksForOld;
  if (stood_ && is_fresh && travel < 0.25 * params_.resolution) return;
  const int steps =
      travel <= kJump ? std::max(1, static_cast<int>(std::ceil(travel / params_.resolution))) : 1;
  for (int i = 1; i <= steps; ++i) {
    const double rest = 1.0 - static_cast<double>(i) / steps;
    cover(outline, {X_MB.x - rest * way.x(), X_MB.y - rest * way.y(), X_MB.theta - rest * turn}, z,
          t);
  }
  stood_ = {X_MB, t};
}

// Does not clear obstacles that were seen.
void LocalMap::cover(const Footprint& outline, const Pose2& X_MB, double z, double t) {
  const double reach = circumradius(outline) + params_.resolution;
  const auto key_at = [&](double off) {
    return tree_.coordToKey(octomap::point3d(
        static_cast<float>(X_MB.x + off), static_cast<float>(X_MB.y + off), static_cast<float>(z)));
  };
  const octomap::OcTreeKey low = key_at(-reach), high = key_at(reach);
  octomap::OcTreeKey key = low;
  for (key[1] = low[1]; key[1] <= high[1]; ++key[1])
    for (key[0] = low[0]; key[0] <= high[0]; ++key[0]) {
      const Eigen::Vector2d p_MC{tree_.keyToCoord(key[0]), tree_.keyToCoord(key[1])};
      if (!window_.contains(key) ||
          distance_to_square(outline, X_MB, p_MC, params_.resolution) > 0.0)
        continue;
      const Node* node = tree_.search(key);
      if (node == nullptr) tree_.setNodeValue(key, kUnsure, true);
      if (node == nullptr || !tree_.isNodeOccupied(node)) covered_.at(key).t = t;
    }
}

// Adds the ray's voxels except the last one to `free_`; one ray for all that end in the same voxel.
void LocalMap::clear_way(const Eigen::Vector3d& p_MS, const Eigen::Vector3d& p_MQ) {
  octomap::OcTreeKey end;
  if (!p_MQ.allFinite() || !tree_.coordToKeyChecked(to_octomap(p_MQ), end)) return;
  if (ends_.size() >= kMaxWays || free_.size() >= kMaxFree || !ends_.insert(end).second) return;
  if (!tree_.computeRayKeys(to_octomap(p_MS), to_octomap(p_MQ), ray_)) return;
  for (const octomap::OcTreeKey& key : ray_)
    if (window_.contains(key)) free_.insert(key);
}

// Removes voxels, occupied or free, that were not covered for too long, including those that would
// exceed their limit before the next search. A voxel with a time later than t was covered before
// the clock was set back.
void LocalMap::forget_old(double t) {
  const double decay = params_.decay > 0.0 ? params_.decay : kForever;
  const double timeout =
      std::max(params_.coverage_timeout - kEarly, 0.75 * params_.coverage_timeout);
  const double soonest = std::min(decay, timeout);
  const double interval = soonest / kLooksForOld;
  if (t >= swept_out_ && t - swept_out_ < interval) return;
  swept_out_ = t;
  covered_.forget_if([&](const octomap::OcTreeKey& key, double covered) {
    const double age = t - covered + interval;
    if (covered <= t && age <= soonest) return false;
    const Node* node = tree_.search(key);
    if (node == nullptr) return true;
    const bool is_old = tree_.isNodeOccupied(node) ? age > decay : covered > t || age > timeout;
    if (is_old) erase_voxel(tree_, key);
    return is_old;
  });
}

// Moves the window in steps and copies what stays inside into a new tree, because
// OcTree::deleteNode of OctoMap 1.9 fails one of its assertions when a node loses its last child.
void LocalMap::follow(const Eigen::Vector3d& p_MS) {
  if ((p_MS - p_MC_).head<2>().cwiseAbs().maxCoeff() < kFollow) return;
  p_MC_ = (p_MS / kFollow).array().round() * kFollow;
  window_ = box_around(p_MC_);
  octomap::OcTree kept = empty_tree(params_);
  for (auto leaf = tree_.begin_leafs(); leaf != tree_.end_leafs(); ++leaf)
    if (window_.contains(leaf.getKey())) kept.setNodeValue(leaf.getKey(), leaf->getLogOdds(), true);
  tree_.swapContent(kept);
  covered_.keep_between(window_.low, window_.high);
}

LocalMap::Box LocalMap::box_around(const Eigen::Vector3d& p_MC) const {
  const double half = 0.5 * params_.window;
  const auto key = [&](double x) { return tree_.coordToKey(x); };
  return {{key(p_MC.x() - half), key(p_MC.y() - half), key(params_.point_cloud_min_z)},
          {key(p_MC.x() + half), key(p_MC.y() + half), key(params_.point_cloud_max_z)}};
}

}  // namespace tandem
