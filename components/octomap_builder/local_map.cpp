// SPDX-License-Identifier: Apache-2.0
#include "octomap_builder/local_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace tandem {
namespace {

constexpr double kFollow = 2.0;    // [m] the window moves in steps of this
constexpr float kUnsure = -0.1F;   // log-odds of a voxel that was forgotten
constexpr double kInside = 0.001;  // [m] an echo's point lies on the surface: just behind it

// Ways that a look clears, and voxels on them: a camera before a wall asks for half of that, a
// cloud of noise would for minutes, in which nothing is heard. What else it met still counts.
constexpr std::size_t kMostWays = 30'000, kMostFree = 1'000'000;

const LocalMapParams& checked(const LocalMapParams& params) {
  check(params);
  if (!(params.point_cloud_min_z < params.point_cloud_max_z))
    throw std::invalid_argument("point_cloud_min_z must be below point_cloud_max_z");
  if (!(params.min_range < params.max_range))
    throw std::invalid_argument("min_range must be below max_range");
  if (octomap::logodds(params.hit) + octomap::logodds(params.clamp_min) <= 0.0F)
    throw std::invalid_argument("hit must be above 1 - clamp_min: one echo is an obstacle");
  return params;
}

octomap::point3d to_octomap(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
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
  for (const octomap::OcTreeKey& key : free_)
    if (occupied_.count(key) == 0) tree_.updateNode(key, false, true);
  for (const octomap::OcTreeKey& key : occupied_) mark(key, t);
  if (params_.decay > 0.0) forget_old(t);
  return true;
}

// Its echoes into `occupied_`, its beams' ways into `free_`.
void LocalMap::look(const Look& look) {
  const auto& [echoes, X_MS] = look;
  const Eigen::Vector3d p_MS = X_MS.translation();
  ends_.clear();
  for (const Eigen::Vector3d& p_SQ : echoes.p_SQ) {
    const double range = p_SQ.norm();
    if (!(range >= params_.min_range) || range == 0.0) continue;  // NaN too
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

// A window round such a point has keys in OctoMap.
double LocalMap::farthest() const {
  constexpr double kKeys = 32767.0;
  return kKeys * params_.resolution - std::max(params_.window, params_.max_range) - kFollow;
}

void LocalMap::clear() {
  tree_.clear();
  seen_.clear();
}

// The ray's voxels but for the one with its end; one ray for all that end in the same.
void LocalMap::clear_way(const Eigen::Vector3d& p_MS, const Eigen::Vector3d& p_MQ) {
  octomap::OcTreeKey end;
  if (!p_MQ.allFinite() || !tree_.coordToKeyChecked(to_octomap(p_MQ), end)) return;
  if (ends_.size() >= kMostWays || free_.size() >= kMostFree || !ends_.insert(end).second) return;
  if (!tree_.computeRayKeys(to_octomap(p_MS), to_octomap(p_MQ), ray_)) return;
  for (const octomap::OcTreeKey& key : ray_)
    if (window_.contains(key)) free_.insert(key);
}

void LocalMap::mark(const octomap::OcTreeKey& key, double t) {
  tree_.updateNode(key, true, true);
  if (params_.decay > 0.0) seen_[key] = t;
}

// What nobody has looked at for long is no obstacle any more, and not surely free.
void LocalMap::forget_old(double t) {
  for (auto it = seen_.begin(); it != seen_.end();) {
    if (t - it->second <= params_.decay) {
      ++it;
      continue;
    }
    const auto* node = tree_.search(it->first);
    if (node != nullptr && tree_.isNodeOccupied(node)) tree_.setNodeValue(it->first, kUnsure, true);
    it = seen_.erase(it);
  }
}

// In steps, into a new tree: OcTree::deleteNode of OctoMap 1.9 fails an assertion of its own when a
// node loses its last child.
void LocalMap::follow(const Eigen::Vector3d& p_MS) {
  if ((p_MS - p_MC_).head<2>().cwiseAbs().maxCoeff() < kFollow) return;
  p_MC_ = (p_MS / kFollow).array().round() * kFollow;
  window_ = box_around(p_MC_);
  octomap::OcTree kept = empty_tree(params_);
  for (auto leaf = tree_.begin_leafs(); leaf != tree_.end_leafs(); ++leaf)
    if (window_.contains(leaf.getKey())) kept.setNodeValue(leaf.getKey(), leaf->getLogOdds(), true);
  tree_.swapContent(kept);
  std::erase_if(seen_, [&](const auto& entry) { return !window_.contains(entry.first); });
}

LocalMap::Box LocalMap::box_around(const Eigen::Vector3d& p_MC) const {
  const double half = 0.5 * params_.window;
  const auto key = [&](double x) { return tree_.coordToKey(x); };
  return {{key(p_MC.x() - half), key(p_MC.y() - half), key(params_.point_cloud_min_z)},
          {key(p_MC.x() + half), key(p_MC.y() + half), key(params_.point_cloud_max_z)}};
}

}  // namespace tandem
