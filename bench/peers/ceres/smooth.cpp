// Batch smoothing by Ceres Solver, with analytic derivatives: the peer of palpate's smoother (cargo xtask bench-peers).
//
// Reads a problem (see ../problem.py for the layout) and solves it once for each line on its input; answers with
// seconds, cost, iterations and the coefficients. What counts is everything from the arrays to the answer: building the problem,
// solving it.

#include <ceres/ceres.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace {

struct Sample {
  double phi1, sin2, cos2, sin1, sin12, s1, s2;
};

struct Problem {
  std::int64_t samples, harmonics;
  double sensor_m, balance_m;
  std::vector<double> prior_m, coefficients, psi;
  std::vector<Sample> data;
};

std::vector<double> Take(std::ifstream& file, std::int64_t count) {
  std::vector<double> values(count);
  file.read(reinterpret_cast<char*>(values.data()), count * sizeof(double));
  return values;
}

Problem Read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Problem problem;
  const auto head = Take(file, 4);
  problem.samples = static_cast<std::int64_t>(head[0]);
  problem.harmonics = static_cast<std::int64_t>(head[1]);
  problem.sensor_m = head[2];
  problem.balance_m = head[3];
  const std::int64_t unknowns = 2 * problem.harmonics + 1;
  problem.prior_m = Take(file, unknowns);
  problem.coefficients = Take(file, unknowns);
  const auto phi1 = Take(file, problem.samples), phi2 = Take(file, problem.samples);
  const auto s1 = Take(file, problem.samples), s2 = Take(file, problem.samples);
  problem.psi = Take(file, problem.samples);
  for (std::int64_t i = 0; i < problem.samples; ++i) {
    problem.data.push_back({phi1[i], std::sin(phi2[i]), std::cos(phi2[i]), std::sin(phi1[i]),
                            std::sin(phi1[i] + phi2[i]), s1[i], s2[i]});
  }
  return problem;
}

// The three residuals of a sample: two contacts and the balance.
template <int K>
class Contact final : public ceres::SizedCostFunction<3, 2 * K + 1, 1> {
 public:
  Contact(const Sample& sample, double sensor_m, double balance_m)
      : sample_(sample), by_sensor_(1.0 / sensor_m), by_balance_(1.0 / balance_m) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double* a = parameters[0];
    const double* b = a + K;
    const double angle = sample_.phi1 - parameters[1][0];
    const double sin = std::sin(angle), cos = std::cos(angle);
    // Contact 1 at angle - pi/2, contact 2 at that + phi2 - pi.
    const double cos1 = sin, sin1 = -cos;
    const double cos2 = sin1 * sample_.sin2 - cos1 * sample_.cos2;
    const double sin2 = -(sin1 * sample_.cos2 + cos1 * sample_.sin2);
    std::array<double, K + 1> c1, s1, c2, s2;
    c1[0] = c2[0] = 1.0;
    s1[0] = s2[0] = 0.0;
    double r1 = a[0], r2 = a[0], d1 = 0.0, d2 = 0.0, v1 = a[0], v2 = a[0];
    for (int k = 1; k <= K; ++k) {
      c1[k] = c1[k - 1] * cos1 - s1[k - 1] * sin1;
      s1[k] = s1[k - 1] * cos1 + c1[k - 1] * sin1;
      c2[k] = c2[k - 1] * cos2 - s2[k - 1] * sin2;
      s2[k] = s2[k - 1] * cos2 + c2[k - 1] * sin2;
      const double term1 = a[k] * c1[k] + b[k] * s1[k];
      const double term2 = a[k] * c2[k] + b[k] * s2[k];
      r1 += term1;
      r2 += term2;
      v1 += (1.0 - k * k) * term1;
      v2 += (1.0 - k * k) * term2;
      d1 += k * (a[k] * s1[k] - b[k] * c1[k]);
      d2 += k * (a[k] * s2[k] - b[k] * c2[k]);
    }
    const double inverse = 1.0 / sample_.sin2, ratio = sample_.cos2 * inverse;
    residuals[0] = by_sensor_ * (r1 * ratio + r2 * inverse - d1 - sample_.s1);
    residuals[1] = by_sensor_ * (r2 * ratio + r1 * inverse + d2 - sample_.s2);
    residuals[2] = by_balance_ * (d1 * sample_.sin12 + d2 * sample_.sin1);
    if (jacobians == nullptr) return true;
    if (jacobians[1] != nullptr) {
      jacobians[1][0] = by_sensor_ * (d1 * ratio + d2 * inverse + r1 - v1);
      jacobians[1][1] = by_sensor_ * (d2 * ratio + d1 * inverse - (r2 - v2));
      jacobians[1][2] = -by_balance_ * ((r1 - v1) * sample_.sin12 + (r2 - v2) * sample_.sin1);
    }
    if (jacobians[0] != nullptr) {
      constexpr int M = 2 * K + 1;
      double* row1 = jacobians[0];
      double* row2 = row1 + M;
      double* row3 = row2 + M;
      row1[0] = row2[0] = by_sensor_ * (ratio + inverse);
      row3[0] = 0.0;
      const double p = by_sensor_ * ratio, q = by_sensor_ * inverse;
      const double g1 = by_balance_ * sample_.sin12, g2 = by_balance_ * sample_.sin1;
      for (int k = 1; k <= K; ++k) {
        row1[k] = p * c1[k] + q * c2[k] - by_sensor_ * k * s1[k];
        row1[K + k] = p * s1[k] + q * s2[k] + by_sensor_ * k * c1[k];
        row2[k] = p * c2[k] + q * c1[k] + by_sensor_ * k * s2[k];
        row2[K + k] = p * s2[k] + q * s1[k] - by_sensor_ * k * c2[k];
        row3[k] = k * (g1 * s1[k] + g2 * s2[k]);
        row3[K + k] = -k * (g1 * c1[k] + g2 * c2[k]);
      }
    }
    return true;
  }

 private:
  const Sample& sample_;
  const double by_sensor_, by_balance_;
};

// The prior of the coefficients.
template <int K>
class Prior final : public ceres::SizedCostFunction<2 * K + 1, 2 * K + 1> {
 public:
  explicit Prior(const std::vector<double>& sd_m) : sd_m_(sd_m) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    constexpr int M = 2 * K + 1;
    for (int i = 0; i < M; ++i) residuals[i] = parameters[0][i] / sd_m_[i];
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::memset(jacobians[0], 0, M * M * sizeof(double));
      for (int i = 0; i < M; ++i) jacobians[0][i * M + i] = 1.0 / sd_m_[i];
    }
    return true;
  }

 private:
  const std::vector<double>& sd_m_;
};

template <int K>
ceres::Solver::Summary Solve(const Problem& given, const ceres::Solver::Options& wanted, std::vector<double>& a,
                             std::vector<double>& psi) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);
  ceres::Solver::Options options = wanted;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::deque<Contact<K>> contacts;
  Prior<K> prior(given.prior_m);
  problem.AddParameterBlock(a.data(), 2 * K + 1);
  problem.AddResidualBlock(&prior, nullptr, a.data());
  options.linear_solver_ordering->AddElementToGroup(a.data(), 1);
  for (std::int64_t i = 0; i < given.samples; ++i) {
    contacts.emplace_back(given.data[i], given.sensor_m, given.balance_m);
    problem.AddResidualBlock(&contacts[i], nullptr, a.data(), &psi[i]);
    // Every orientation is eliminated before the shape.
    options.linear_solver_ordering->AddElementToGroup(&psi[i], 0);
  }
  // The common rotation is free: one orientation stays.
  problem.SetParameterBlockConstant(&psi[0]);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary;
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::cerr << "usage: smooth PROBLEM THREADS TOLERANCE\n";
    return 2;
  }
  const Problem given = Read(words[1]);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.num_threads = std::stoi(words[2]);
  options.function_tolerance = std::stod(words[3]);
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  std::string line;
  while (std::getline(std::cin, line)) {
    if (line == "sparse") options.linear_solver_type = ceres::SPARSE_SCHUR;
    if (line == "dense") options.linear_solver_type = ceres::DENSE_SCHUR;
    std::vector<double> a = given.coefficients, psi = given.psi;
    const auto began = std::chrono::steady_clock::now();
    ceres::Solver::Summary summary;
    switch (given.harmonics) {
      case 8: summary = Solve<8>(given, options, a, psi); break;
      case 16: summary = Solve<16>(given, options, a, psi); break;
      case 32: summary = Solve<32>(given, options, a, psi); break;
      default: std::cout << "error it is compiled for 8, 16 and 32 harmonics" << std::endl; continue;
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (line == "report") std::cerr << summary.FullReport() << "\n";
    std::printf("%.9f %.15e %zu", seconds, 2.0 * summary.final_cost, summary.iterations.size() - 1);
    for (const double value : a) std::printf(" %.17g", value);
    std::printf("\n");
    std::fflush(stdout);
  }
}
