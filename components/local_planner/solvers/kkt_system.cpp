// SPDX-License-Identifier: Apache-2.0
// The rows (4) of a stage share Δs and γ, the gradient of the speed-dependent margin. With
// Σᵢ = yᵢ / tᵢ, rᵢ the residual and pᵢ the gradient of the clearance, pair i adds to the model
//
//   ½ Σᵢ (pᵢ·ΔX⁺ − γ·Δu + Δs + rᵢ)² − μ/tᵢ (pᵢ·ΔX⁺ − γ·Δu + Δs)                              (3)
//
// Minimising over Δs subtracts v vᵀ / (Σ_s + S), where S = Σ Σᵢ and v = (Σ Σᵢ pᵢ, −S γ).
#include "tandem/local_planner/solvers/kkt_system.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/local_planner/solvers/two_rows.hpp"

namespace tandem {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

constexpr double kMin = 1e-10, kMax = 1e10;  // limits of a multiplier, relative to μ / distance
constexpr double kTau = 0.99;                // least fraction of a distance that a step may use up
constexpr int kAttempts = 40;                // factorisations before giving up
constexpr double kDropsCurvature = 10.0;     // regularisation above which curvature is dropped

Two clamp(const Two& multipliers, const Two& centred) {
  return multipliers.max(kMin * centred).min(kMax * centred);
}

// Derivative of the pose at the end of a stage with respect to the mean twist.
Matrix32 by_mean(const Ocp& ocp, const Displacement& motion) {
  Matrix32 B;
  B << motion.d_v.x(), motion.d_w.x(), motion.d_v.y(), motion.d_w.y(), 0.0, ocp.dt;
  return B;
}

// Turns derivatives with respect to the mean twist, share · a + (1 − share) · u, into derivatives
// with respect to a and u.
void share_out(const LagStep& lag, ChainStage<5>& out) {
  const Vector2d of_a{lag.share_v, lag.share_w}, of_u = Vector2d::Ones() - of_a;
  const Matrix2d C = out.C_uu;
  const Vector2d t = out.t_u;
  const Matrix32 B = out.B.topRows<3>();
  out.lag.E << lag.decay_v, lag.decay_w;
  out.lag.M = B * of_a.asDiagonal();
  out.lag.t_a = of_a.cwiseProduct(t);
  out.lag.C_aa = of_a.asDiagonal() * C * of_a.asDiagonal();
  out.lag.C_au = of_a.asDiagonal() * C * of_u.asDiagonal();
  out.C_uu = of_u.asDiagonal() * C * of_u.asDiagonal();
  out.t_u = of_u.cwiseProduct(t);
  out.B << B * of_u.asDiagonal(), Matrix2d{(Vector2d::Ones() - out.lag.E).asDiagonal()};
}

// Largest fraction of a step, at most 1, that keeps −Δ / distance ≤ τ. `worst`: ratio of the full
// step.
double allowed(double worst, double tau) { return worst > tau ? tau / worst : 1.0; }

}  // namespace

template <int n>
void Multipliers<n>::resize(std::size_t stage_count, std::size_t pair_count) {
  lower.resize(block_of(n) * stage_count);
  upper.resize(block_of(n) * stage_count);
  y.resize(pair_count);
  pi.resize(stage_count);
  lambda.resize(stage_count);
}

template <int n>
void Step<n>::resize(std::size_t stage_count, std::size_t pair_count) {
  for (auto* values : {&z, &lower, &upper}) values->resize(block_of(n) * stage_count);
  for (auto* values : {&t, &y}) values->resize(pair_count);
  chain.resize(stage_count);
}

template <int n>
void KktSystem<n>::resize(std::size_t stage_count, std::size_t pair_count) {
  stages_.resize(stage_count);
  gains_.resize(stage_count);
  slacks_.resize(stage_count);
  for (auto* values : {&per_lower_, &per_upper_, &sigma_, &barrier_})
    values->resize(kBlock * stage_count);
  per_t_.resize(pair_count);
}

template <int n>
void KktSystem<n>::condense(const Ocp& ocp, const Box& box, const IpIterate<n>& point, double mu,
                            Multipliers<n>& multipliers) {
  dual_ = multipliers_ = largest_product_ = 0.0;
  least_product_ = Box::kFar;
  violation_ = point.violation;
  condense_bounds(box, point, mu, multipliers);
  std::size_t row = 0;
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const std::size_t end = row + ocp.stages[k].pairs.size();
    const PairSums pairs = condense_pairs({row, end}, point, mu, multipliers);
    condense_stage(ocp, k, point.stages[k], pairs, multipliers.pi[k]);
    look_at_dual(ocp, k, point, pairs, multipliers);
    row = end;
  }
}

template <int n>
void KktSystem<n>::condense_bounds(const Box& box, const IpIterate<n>& point, double mu,
                                   Multipliers<n>& multipliers) {
  Two least = Two::Constant(Box::kFar), largest = Two::Zero(), sum = Two::Zero();
  for (std::size_t i = 0; i < point.z.size(); i += 2) {
    const Two z = two(point.z, i);
    const Two below = z - two(box.lower, i), above = two(box.upper, i) - z;
    const Two per_both = (below * above).inverse();
    const Two per_below = per_both * above, per_above = per_both * below;
    const Two lower = clamp(two(multipliers.lower, i), mu * per_below);
    const Two upper = clamp(two(multipliers.upper, i), mu * per_above);
    const Two product_below = lower * below, product_above = upper * above;
    two(multipliers.lower, i) = lower;
    two(multipliers.upper, i) = upper;
    two(per_lower_, i) = per_below;
    two(per_upper_, i) = per_above;
    two(sigma_, i) = lower * per_below + upper * per_above;
    two(barrier_, i) = mu * (per_above - per_below);
    least = least.min(product_below).min(product_above);
    largest = largest.max(product_below).max(product_above);
    sum += lower + upper;
  }
  least_product_ = std::min(least_product_, least.minCoeff());
  largest_product_ = std::max(largest_product_, largest.maxCoeff());
  multipliers_ += sum.sum();
}

template <int n>
typename KktSystem<n>::PairSums KktSystem<n>::condense_pairs(Rows rows, const IpIterate<n>& point,
                                                             double mu,
                                                             Multipliers<n>& multipliers) {
  if (rows.first == rows.end) return {};
  const PairTable& pairs = point.pairs;
  // Local sums, because members might alias the stores below.
  Two sigma_sum = Two::Zero(), y_sum = Two::Zero(), gradient_sum = Two::Zero();
  Two least = Two::Constant(least_product_), largest = Two::Constant(largest_product_);
  VectorSum sigma_n, y_n, gradient_n;
  OuterSum H, C;
  for (std::size_t i = rows.first; i < rows.end; i += 2) {
    const std::size_t other = i + 1 < rows.end ? 1 : 0;
    const Two counted{1.0, static_cast<double>(other)};
    const Two t = two_rows(point.t, i, other), per = t.inverse(), centred = mu * per;
    const Two clamped = clamp(two_rows(multipliers.y, i, other), centred), product = clamped * t;
    set_two_rows(multipliers.y, i, other, clamped);
    set_two_rows(per_t_, i, other, per);
    least = least.min(product);
    largest = largest.max(product);

    const Two y = counted * clamped, sigma = y * per;
    const Two gradient = counted * centred - sigma * two_rows(point.residuals, i, other);
    const Two n_x = two(pairs.n_x, i), n_y = two(pairs.n_y, i), turn = two(pairs.turn, i);
    const Two lean = two(pairs.lean, i);
    sigma_sum += sigma;
    y_sum += y;
    gradient_sum += gradient;
    sigma_n.add(sigma, n_x, n_y, turn);
    y_n.add(y, n_x, n_y, turn);
    gradient_n.add(gradient, n_x, n_y, turn);
    H.add(sigma, n_x, n_y, turn);
    C.add(-y * two(pairs.curvature, i), -n_y, n_x, lean);  // along() of PairTerms
    C.tt += y * lean;
  }
  least_product_ = least.minCoeff();
  largest_product_ = largest.maxCoeff();
  return {sigma_sum.sum(), y_sum.sum(),        gradient_sum.sum(), sigma_n.value(),
          y_n.value(),     gradient_n.value(), H.value(),          C.value()};
}

template <int n>
void KktSystem<n>::condense_stage(const Ocp& ocp, std::size_t k, const StageTerms<n>& stage,
                                  const PairSums& pairs, const ChainState<n>& pi) {
  const double *sigma = &sigma_[kBlock * k], *barrier = &barrier_[kBlock * k];
  const double per = 1.0 / (sigma[kSlack] + pairs.sigma);
  const double gradient = ocp.slack_weight + barrier[kSlack] - pairs.gradient;
  const double stiffness = sigma[kSlack] * per;  // share that the rows keep with s eliminated
  slacks_[k] = {per, gradient, pairs.sigma, pairs.sigma_n};

  ChainStage<n>& out = stages_[k];
  Eigen::Matrix3d H_pose = pairs.H - per * pairs.sigma_n * pairs.sigma_n.transpose();
  H_pose.diagonal() += stage.cost.X2 + Vector3d{sigma[kX], sigma[kY], sigma[kTheta]};
  H_pose(0, 1) += stage.cost.xy;
  H_pose(1, 0) += stage.cost.xy;
  const Vector3d h_pose = stage.cost.X + Vector3d{barrier[kX], barrier[kY], barrier[kTheta]} -
                          pairs.gradient_n - per * gradient * pairs.sigma_n;
  if constexpr (n == 5) {
    out.H_xx.setZero();
    out.H_xx.diagonal().template tail<2>() << sigma[kMotionV], sigma[kMotionW];
    out.h_x.template tail<2>() << barrier[kMotionV], barrier[kMotionW];
  }
  out.H_xx.template topLeftCorner<3, 3>() = H_pose;
  out.h_x.template head<3>() = h_pose;
  out.H_xu = -stiffness * pairs.sigma_n * stage.speed_margin.transpose();
  out.H_uu = stiffness * pairs.sigma * stage.speed_margin * stage.speed_margin.transpose();
  out.H_uu(0, 0) += stage.cost.vv + sigma[kV] + 2.0 * ocp.gap_v * pairs.y;
  out.H_uu(1, 1) += stage.cost.ww + sigma[kW] + 2.0 * ocp.gap_w * pairs.y;
  out.H_uu(0, 1) += stage.cost.vw;
  out.H_uu(1, 0) += stage.cost.vw;
  out.h_u = stage.cost.u + Vector2d{barrier[kV], barrier[kW]} +
            (pairs.gradient + per * gradient * pairs.sigma) * stage.speed_margin;

  out.C_xx = pairs.C;
  out.D = stage.cost.change2 + Vector2d{sigma[kDv], sigma[kDw]};
  out.g = stage.cost.change + Vector2d{barrier[kDv], barrier[kDw]};
  out.e = stage.change;
  condense_motion(ocp, stage, pi, out);
}

template <int n>
void KktSystem<n>::condense_motion(const Ocp& ocp, const StageTerms<n>& stage,
                                   const ChainState<n>& pi, ChainStage<n>& out) {
  const Displacement& motion = stage.motion;
  const Vector2d l = pi.template head<2>();
  const double vw = l.dot(motion.d_v_w);
  out.C_uu << 0.0, vw, vw, l.dot(motion.d_w_w);
  out.t = l.dot(motion.d_theta_theta);
  out.t_u = {l.dot(motion.d_theta_v), l.dot(motion.d_theta_w)};
  out.a = motion.d_theta;
  out.B.template topRows<3>() = by_mean(ocp, motion);
  out.c = stage.gap;
  if constexpr (n == 5) share_out(ocp.lag, out);
}

template <int n>
void KktSystem<n>::look_at_dual(const Ocp& ocp, std::size_t k, const IpIterate<n>& point,
                                const PairSums& pairs, const Multipliers<n>& multipliers) {
  const StageTerms<n>& stage = point.stages[k];
  const ChainState<n>& pi = multipliers.pi[k];
  const Vector2d& lambda = multipliers.lambda[k];
  const auto bound = [&](int place) {
    const std::size_t i = kBlock * k + static_cast<std::size_t>(place);
    return multipliers.upper[i] - multipliers.lower[i];
  };
  Vector2d u = stage.cost.u + Vector2d{bound(kV), bound(kW)} + lambda +
               pairs.y * stage.speed_margin + stages_[k].B.transpose() * pi;
  ChainState<n> X = -pi;
  X.template head<3>() += stage.cost.X + Vector3d{bound(kX), bound(kY), bound(kTheta)} - pairs.y_n;
  if constexpr (n == 5) X.template tail<2>() += Vector2d{bound(kMotionV), bound(kMotionW)};
  if (k + 1 < point.stages.size()) {
    const ChainState<n>& pi_after = multipliers.pi[k + 1];
    const Displacement& motion_after = point.stages[k + 1].motion;
    u -= multipliers.lambda[k + 1];
    X.template head<3>() += pi_after.template head<3>();
    X.z() += motion_after.d_theta.dot(pi_after.template head<2>());
    if constexpr (n == 5) {
      const LagStep& lag = ocp.lag;
      const Vector2d by = by_mean(ocp, motion_after).transpose() * pi_after.template head<3>();
      X[3] += lag.share_v * by.x() + lag.decay_v * pi_after[3];
      X[4] += lag.share_w * by.y() + lag.decay_w * pi_after[4];
    }
  }
  const Vector2d d = stage.cost.change + Vector2d{bound(kDv), bound(kDw)} - lambda;
  const double s = ocp.slack_weight + bound(kSlack) - pairs.y;
  dual_ = std::max({dual_, u.lpNorm<Eigen::Infinity>(), X.template lpNorm<Eigen::Infinity>(),
                    d.lpNorm<Eigen::Infinity>(), std::abs(s)});
  multipliers_ += 2.0 * pairs.y + pi.template lpNorm<1>() + lambda.lpNorm<1>();
}

template <int n>
double KktSystem<n>::complementarity(double mu) const {
  return std::max(largest_product_ - mu, mu - least_product_);
}

template <int n>
double KktSystem<n>::error(double mu) const {
  constexpr double kOrdinary = 100.0;  // mean multiplier above which the error is scaled down
  const auto count =
      static_cast<double>((2 * kBlock + equalities_of(n)) * stages_.size() + 2 * per_t_.size());
  const double scale = std::max(kOrdinary, multipliers_ / count) / kOrdinary;
  return std::max({dual_ / scale, violation_, complementarity(mu) / scale});
}

// Increases the regularisation until the pivots are positive definite. If that takes too much, the
// curvature of pairs and motion is dropped instead; the rest is convex or nearly so.
template <int n>
bool KktSystem<n>::factorize_convex() {
  const double before = last_delta_;
  Convexity convexity;
  for (int i = 0; !factorize<n>(stages_, convexity, gains_); ++i) {
    if (i == kAttempts) return false;
    double& delta = convexity.delta;
    if (delta == 0.0)
      delta = before == 0.0 ? 1e-2 : std::max(1e-4, before / 3.0);
    else
      delta *= before == 0.0 ? 20.0 : 8.0;
    if (delta > kDropsCurvature && convexity.curvature > 0.0) convexity = {0.0, 0.0};
    if (delta > 0.0) last_delta_ = delta;
  }
  return true;
}

template <int n>
bool KktSystem<n>::solve(const Ocp& ocp, const IpIterate<n>& point, double mu,
                         const Multipliers<n>& multipliers, Step<n>& step) {
  if (!factorize_convex()) return false;
  roll_out<n>(stages_, gains_, step.chain);
  step.slope = step.worst_primal = step.worst_dual = 0.0;
  std::size_t row = 0;
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const StageTerms<n>& stage = point.stages[k];
    const ChainStep<n>& chain = step.chain[k];
    const SlackTerms& slack = slacks_[k];
    const double grown = stage.speed_margin.dot(chain.u);
    const double ds = -slack.per * (slack.gradient + slack.weights.dot(chain.X.template head<3>()) -
                                    slack.sum * grown);
    double* z = &step.z[kBlock * k];
    const double all[kSlack + 1] = {chain.u.x(), chain.u.y(), chain.d.x(), chain.d.y(),
                                    chain.X.x(), chain.X.y(), chain.X.z(), ds};
    std::copy(std::begin(all), std::end(all), z);
    if constexpr (n == 5) z[kMotionV] = chain.X[3], z[kMotionW] = chain.X[4];
    const Vector3d pose = chain.X.template head<3>();
    step.slope += stage.cost.u.dot(chain.u) + stage.cost.X.dot(pose) +
                  stage.cost.change.dot(chain.d) + ocp.slack_weight * ds;
    const std::size_t end = row + ocp.stages[k].pairs.size();
    expand_pairs({row, end}, point, mu, multipliers, {pose, ds - grown}, step);
    row = end;
  }
  expand_bounds(mu, multipliers, step);
  const double tau = std::max(kTau, 1.0 - mu);
  step.alpha_primal = allowed(step.worst_primal, tau);
  step.alpha_dual = allowed(step.worst_dual, tau);
  return std::isfinite(step.slope);
}

template <int n>
void KktSystem<n>::expand_pairs(Rows rows, const IpIterate<n>& point, double mu,
                                const Multipliers<n>& multipliers, const PairStep& by,
                                Step<n>& step) const {
  if (rows.first == rows.end) return;
  const PairTable& pairs = point.pairs;
  Two logs = Two::Zero(), primal = Two::Constant(step.worst_primal);
  Two dual = Two::Constant(step.worst_dual);
  for (std::size_t i = rows.first; i < rows.end; i += 2) {
    const std::size_t other = i + 1 < rows.end ? 1 : 0;
    const Two y = two_rows(multipliers.y, i, other), per = two_rows(per_t_, i, other);
    const Two n_x = two_rows(pairs.n_x, i, other), n_y = two_rows(pairs.n_y, i, other);
    const Two turn = two_rows(pairs.turn, i, other);
    const Two dt = n_x * by.X.x() + n_y * by.X.y() + turn * by.X.z() + by.offset +
                   two_rows(point.residuals, i, other);
    const Two relative = dt * per, dy = mu * per - y - y * relative;
    set_two_rows(step.t, i, other, dt);
    set_two_rows(step.y, i, other, dy);
    logs += Two{1.0, static_cast<double>(other)} * relative;
    primal = primal.max(-relative);
    dual = dual.max(-dy / y);
  }
  step.slope -= mu * logs.sum();
  step.worst_primal = primal.maxCoeff();
  step.worst_dual = dual.maxCoeff();
}

template <int n>
void KktSystem<n>::expand_bounds(double mu, const Multipliers<n>& multipliers,
                                 Step<n>& step) const {
  Two slope = Two::Zero(), primal = Two::Zero(), dual = Two::Zero();
  for (std::size_t i = 0; i < step.z.size(); i += 2) {
    const Two z = two(step.z, i), lower = two(multipliers.lower, i),
              upper = two(multipliers.upper, i), per_lower = two(per_lower_, i),
              per_upper = two(per_upper_, i);
    const Two below = z * per_lower, above = z * per_upper;
    const Two d_lower = mu * per_lower - lower - lower * below;
    const Two d_upper = mu * per_upper - upper + upper * above;
    two(step.lower, i) = d_lower;
    two(step.upper, i) = d_upper;
    slope += two(barrier_, i) * z;
    primal = primal.max(above).max(-below);
    dual = dual.max(-d_lower / lower).max(-d_upper / upper);
  }
  step.slope += slope.sum();
  step.worst_primal = std::max(step.worst_primal, primal.maxCoeff());
  step.worst_dual = std::max(step.worst_dual, dual.maxCoeff());
}

template struct Multipliers<3>;
template struct Multipliers<5>;
template struct Step<3>;
template struct Step<5>;
template class KktSystem<3>;
template class KktSystem<5>;

}  // namespace tandem
