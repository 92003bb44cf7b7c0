#include "robot/settling.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace primo::robot {
namespace {

constexpr double kClosed = 1e-4;                            // m, rad
constexpr double kAtRest = 1e-9;                            // rad of a step
constexpr double kLongestStep = 0.1;                        // rad
constexpr double kSlideRadian = 0.1;                        // m of a slide that count as a radian
constexpr int kMostSteps = 3000;                            // soft springs beside stiff ones are slow
constexpr int kMostClosingSteps = 30;                       // without springs it is Newton's method
constexpr std::array<mjtNum, 2> kUnitStiffness = {-1, -1};  // MuJoCo's direct form: stiffness, damping
// As hard as MuJoCo makes them, wherever they are.
constexpr std::array<mjtNum, 5> kHard = {mjMAXIMP, mjMAXIMP, 0.001, 0.5, 2};

void make_hard(mjtNum* solref, mjtNum* solimp) {
  std::copy(kUnitStiffness.begin(), kUnitStiffness.end(), solref);
  std::copy(kHard.begin(), kHard.end(), solimp);
}

/// The stiffness of the springs that act on each dof, and their torque's largest change by turning.
Eigen::VectorXd spring_scale(const mjModel& m) {
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(m.nv);
  for (int j = 0; j < m.njnt; ++j) {
    const int q = m.jnt_qposadr[j];
    scale[m.jnt_dofadr[j]] += m.jnt_stiffness[j] * (1 + std::abs(m.qpos0[q] - m.qpos_spring[q]));
  }
  for (int t = 0; t < m.ntendon; ++t) {
    for (int w = m.tendon_adr[t]; w < m.tendon_adr[t] + m.tendon_num[t]; ++w) {
      if (m.wrap_type[w] != mjWRAP_JOINT) continue;
      const double arm = std::abs(m.wrap_prm[w]), off = std::abs(m.tendon_length0[t] - m.tendon_lengthspring[t]);
      scale[m.jnt_dofadr[m.wrap_objid[w]]] += m.tendon_stiffness[t] * arm * (arm + off);
    }
  }
  return scale;
}

/// Equalities between held joints: nothing can be done about them.
void leave_out_held(mjModel& m, const std::vector<char>& free) {
  for (int e = 0; e < m.neq; ++e) {
    if (m.eq_type[e] != mjEQ_JOINT) continue;
    const int a = m.eq_obj1id[e], b = m.eq_obj2id[e];
    if (!free[static_cast<std::size_t>(a)] && (b < 0 || !free[static_cast<std::size_t>(b)])) m.eq_active[e] = 0;
  }
}

}  // namespace

bool Settling::Rest::closed() const { return found && open <= kClosed; }

Settling::Settling(const mjModel& model, const std::vector<char>& free)
    : model_(mj_copyModel(nullptr, &model)), data_(nullptr, &mj_deleteData) {
  mjModel& m = *model_;
  constexpr double kHeld = 1e8;  // times the inertia of a free joint
  for (int j = 0; j < m.njnt; ++j) {
    if (free[static_cast<std::size_t>(j)]) free_.push_back(j);
  }
  const Eigen::VectorXd springs = spring_scale(m);
  const double largest = springs.maxCoeff(), common = largest > 0 ? largest : 1;
  std::fill_n(m.dof_armature, m.nv, kHeld * common);
  std::fill_n(m.body_mass, m.nbody, 0.0);
  std::fill_n(m.body_inertia, 3 * m.nbody, 0.0);
  for (int j = 0; j < m.njnt; ++j) {
    const bool moves = free[static_cast<std::size_t>(j)] != 0;
    const int dof = m.jnt_dofadr[j];
    if (moves) m.dof_armature[dof] = springs[dof] > 0 ? springs[dof] : common;
    m.jnt_limited[j] = m.jnt_limited[j] && moves;
    m.jnt_margin[j] = 0;
    make_hard(m.jnt_solref + mjNREF * j, m.jnt_solimp + mjNIMP * j);
  }
  for (int t = 0; t < m.ntendon; ++t) make_hard(m.tendon_solref_lim + mjNREF * t, m.tendon_solimp_lim + mjNIMP * t);
  for (int e = 0; e < m.neq; ++e) make_hard(m.eq_solref + mjNREF * e, m.eq_solimp + mjNIMP * e);
  leave_out_held(m, free);
  m.opt.disableflags |= mjDSBL_CONTACT | mjDSBL_GRAVITY | mjDSBL_FRICTIONLOSS | mjDSBL_ACTUATION | mjDSBL_SENSOR;
  m.opt.jacobian = mjJAC_DENSE;
  m.opt.solver = mjSOL_NEWTON;
  m.opt.iterations = 50;
  m.opt.tolerance = 1e-20;
  m.opt.noslip_iterations = 0;
  data_.reset(mj_makeData(&m));
  mj_setConst(&m, data_.get());
  m.stat.meaninertia =
      common;  // what the solver's tolerance is measured by; that of the held joints would end it at once
  mj_resetData(&m, data_.get());
}

double Settling::step(double part) {
  const mjModel& m = *model_;
  mj_forward(&m, data_.get());
  Eigen::VectorXd way(static_cast<Eigen::Index>(free_.size()));
  for (Eigen::Index i = 0; i < way.size(); ++i) {
    const int j = free_[static_cast<std::size_t>(i)];
    way[i] = data_->qacc[m.jnt_dofadr[j]] / (m.jnt_type[j] == mjJNT_SLIDE ? kSlideRadian : 1.0);
  }
  if (!way.allFinite()) return std::numeric_limits<double>::infinity();
  const double largest = way.size() ? way.cwiseAbs().maxCoeff() : 0.0;
  const double fraction = largest * part > kLongestStep ? kLongestStep / largest : part;
  for (const int j : free_) data_->qpos[m.jnt_qposadr[j]] += fraction * data_->qacc[m.jnt_dofadr[j]];
  turned_back_ = way_.size() == way.size() && way_.squaredNorm() > 0 ? -way.dot(way_) / way_.squaredNorm() : 0;
  way_ = std::move(way);
  return largest;
}

Settling::Rest Settling::settle(bool find_unheld) {
  bool found = false;
  double part = 1;
  way_.resize(0);
  for (int k = 0; k < kMostSteps && !found; ++k) {
    const double moved = step(part);
    if (!std::isfinite(moved)) return {};
    found = moved < kAtRest;
    if (turned_back_ > 0.6) part = std::max(part / 2, 1e-3);
  }
  const int loose = find_unheld ? unheld() : -1;
  model_->opt.disableflags |= mjDSBL_PASSIVE;
  for (int k = 0; k < kMostClosingSteps; ++k) {
    if (!(step(1) >= 1e-3 * kAtRest)) break;
  }
  Rest rest = measure();
  model_->opt.disableflags &= ~mjDSBL_PASSIVE;
  rest.found = found;
  rest.unheld = loose;
  return rest;
}

Settling::Rest Settling::measure() {
  mj_forward(model_.get(), data_.get());
  Rest rest;
  rest.found = true;
  for (int row = 0; row < data_->nefc; ++row) {
    const int type = data_->efc_type[row];
    const bool equality = type == mjCNSTR_EQUALITY;
    // A limit is only missed on one side.
    const double open = equality ? std::abs(data_->efc_pos[row]) : -data_->efc_pos[row];
    if (!(open > rest.open)) continue;
    rest.open = open;
    rest.equality = equality ? data_->efc_id[row] : -1;
    rest.joint = type == mjCNSTR_LIMIT_JOINT ? data_->efc_id[row] : -1;
  }
  return rest;
}

/// A joint is held when no motion that leaves all constraints met and all springs as they are moves it: the sum of
/// their squared rates of change has to be definite.
int Settling::unheld() const {
  const mjModel& m = *model_;
  const auto n = static_cast<Eigen::Index>(free_.size());
  const auto row_of = [&](auto entry) {
    Eigen::VectorXd row(n);
    for (Eigen::Index i = 0; i < n; ++i) row[i] = entry(free_[static_cast<std::size_t>(i)]);
    return row;
  };
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  const auto add = [&](const Eigen::VectorXd& row) {
    const double norm = row.norm();
    if (norm > 1e-9) H += row * row.transpose() / (norm * norm);
  };
  for (int row = 0; row < data_->nefc; ++row) {
    const bool loaded = data_->efc_force[row] > 1e-6 * m.stat.meaninertia;
    if (data_->efc_type[row] != mjCNSTR_EQUALITY && !loaded) continue;  // a limit that nothing rests on
    add(row_of([&](int j) { return data_->efc_J[row * m.nv + m.jnt_dofadr[j]]; }));
  }
  for (Eigen::Index i = 0; i < n; ++i) H(i, i) += m.jnt_stiffness[free_[static_cast<std::size_t>(i)]] > 0 ? 1 : 0;
  for (int t = 0; t < m.ntendon; ++t) {
    if (m.tendon_stiffness[t] <= 0) continue;
    add(row_of([&](int j) {
      double arm = 0;
      for (int w = m.tendon_adr[t]; w < m.tendon_adr[t] + m.tendon_num[t]; ++w)
        arm += m.wrap_type[w] == mjWRAP_JOINT && m.wrap_objid[w] == j ? m.wrap_prm[w] : 0;
      return arm;
    }));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H);
  if (n == 0 || eigen.eigenvalues()[0] > 1e-9) return -1;
  Eigen::Index joint = 0;
  eigen.eigenvectors().col(0).cwiseAbs().maxCoeff(&joint);
  return free_[static_cast<std::size_t>(joint)];
}

}  // namespace primo::robot
