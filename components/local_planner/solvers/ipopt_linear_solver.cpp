// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/ipopt_linear_solver.hpp"

#include <algorithm>

#ifdef TANDEM_IPOPT_TAKES_MA27
#include <HSLLoader.h>
#endif

namespace tandem {
namespace {

struct Active {
  SparseLdl* factors = nullptr;
  const std::vector<Pivot>* order = nullptr;
  bool is_used = false;
};
thread_local Active active;

#ifdef TANDEM_IPOPT_TAKES_MA27
std::size_t count(const int* n) { return static_cast<std::size_t>(*n); }

// MA27's four subroutines, with the arguments that HSL documents. Ipopt reads from INFO: (1)
// status, 0, or 3 if singular; (2) rank; (5), (6) lengths to provide for A and IW; (15) number of
// negative eigenvalues.
void ma27_defaults(int*, double*) {}

void ma27_analyse(int* n, int* nz, const int* rows, const int* columns, int*, int*, int*, int*,
                  int* steps, int*, int*, double*, int* info, double*) {
  active.factors->analyse(*n, {rows, count(nz)}, {columns, count(nz)}, *active.order);
  std::fill(info, info + 20, 0);
  info[4] = info[5] = *steps = 1;
}

void ma27_factorize(int* n, int* nz, const int*, const int*, double* values, int*, int*, int*, int*,
                    int*, int* most_rows, int*, int*, double*, int* info) {
  active.is_used = true;
  std::fill(info, info + 20, 0);
  *most_rows = 1;
  if (active.factors->factorize({values, count(nz)})) {
    info[14] = active.factors->negative();
  } else {
    info[0] = 3;
    info[1] = *n - 1;
  }
}

void ma27_solve(int* n, double*, int*, int*, int*, double*, int*, double* b, int*, int*, int*,
                double*) {
  active.factors->solve({b, count(n)});
}

bool plug_in() {
  LSL_setMA27(ma27_analyse, ma27_factorize, ma27_solve, ma27_defaults);
  return true;
}
#endif

}  // namespace

std::vector<Pivot> stage_pivots(const Ocp& ocp) {
  const int stages = ocp.horizon(), length = static_cast<int>(block(ocp)),
            each = static_cast<int>(equalities(ocp));
  const int pairs = rows(ocp) - each * stages;
  const int slack = length * stages, equality = slack + pairs, pair = equality + each * stages;
  std::vector<Pivot> order;
  for (int i = 0; i < pairs; ++i) order.push_back({slack + i});
  for (int i = 0; i < pairs; ++i) order.push_back({pair + i});
  for (int k = stages - 1; k >= 0; --k) {
    const int z = length * k, row = equality + each * k;
    order.push_back({z + kSlack});
    order.push_back({z + kDv, row});
    order.push_back({z + kDw, row + 1});
    for (int i = 0; i < 3; ++i) order.push_back({z + kX + i, row + 2 + i});
    for (int i = 5; i < each; ++i) order.push_back({z + kMotionV + i - 5, row + i});
    order.push_back({z + kV, z + kW});
  }
  return order;
}

bool takes_linear_solver() {
#ifdef TANDEM_IPOPT_TAKES_MA27
  static const bool plugged = plug_in();
  return plugged;
#else
  return false;
#endif
}

AsMa27::AsMa27(SparseLdl& factors, const std::vector<Pivot>& order) { active = {&factors, &order}; }
AsMa27::~AsMa27() { active = {}; }
bool AsMa27::is_used() const { return active.is_used; }

}  // namespace tandem
