#pragma once

#include <array>
#include <vector>

#include "core/math/vec.h"
#include "core/shade/light_matrix.h"

namespace relume {

/// A record while it is being fitted: one member's sample vector, of which colours, direction and
/// scalar are free within bounds. Colours here are those of the whole cluster: not yet divided by
/// its weight.
struct FitRecord {
  int type = 0;
  std::vector<float> vector;  ///< the anchor's; direction and scalar current, colours stale
  float color[max_lobes][3] = {};
  float upper[max_lobes][3] = {};  ///< colours stay within [0, upper]
  float prior[max_lobes][3] = {};  ///< the members' own sums
  vec3 cone_axis{0, 0, 1};  ///< the direction stays within the cone of the members' directions
  float cone_cos = -1;
  float scalar_low = 0;
  float scalar_high = 0;
};

/// Fits records together, by Levenberg-Marquardt with analytic derivatives, to
///   |sum_r f_r - t|^2 + rho sum_r |f_r - t_r|^2 + mu sum_r prior_r
/// where f_r is the record's response under the training lights (3 channels x columns), t the whole
/// target, t_r the record's cluster's. Colours enter linearly and are eliminated by a Schur
/// complement, so that one step solves a dense system of 3 unknowns a record. Buffers are kept.
class RecordFitter {
 public:
  /// `column_scale`: factor per light that all responses and targets carry.
  RecordFitter(const LobeEvaluator& evaluator, std::span<const float> column_scale);

  /// Up to `steps` steps on `records`; `targets` holds t_r, 3 x columns floats each, in record
  /// order; t is their sum. Never makes the objective worse.
  void fit(std::vector<FitRecord>& records, const std::vector<float>& targets, float rho, float mu,
           int steps);

 private:
  struct Responses {
    std::vector<float> lobes;  ///< record x max_lobes x 4 x columns: value, three derivatives
    double cost = 0;
  };

  void evaluate(const std::vector<FitRecord>& records, Responses& responses);
  void add_response(const FitRecord& record, const float* lobes, float* out) const;
  double objective(const std::vector<FitRecord>& records, const Responses& responses);
  void build_system(const std::vector<FitRecord>& records, const Responses& responses);
  bool solve(const std::vector<FitRecord>& records, double damping);
  std::vector<FitRecord> step(const std::vector<FitRecord>& records) const;

  const float* lobe(const Responses& responses, size_t record, int k, int derivative) const {
    return &responses.lobes[((record * max_lobes + k) * 4 + derivative) * columns_];
  }

  const LobeEvaluator& evaluator_;
  std::span<const float> scale_;
  size_t columns_;
  float rho_ = 0;
  float mu_ = 0;
  const std::vector<float>* targets_ = nullptr;
  std::vector<float> energy_;    ///< per record and lobe, for the prior
  std::vector<float> residual_;  ///< 3 x columns: sum_r f_r - t
  std::vector<float> own_;       ///< record x 3 x columns: f_r - t_r
  std::vector<float> geometry_;  ///< 3 per record, each 3 x columns
  std::vector<float> values_;    ///< max_lobes per record, each columns
  std::vector<float> products_;
  // Normal equations: colours per channel (n_v = 2 records), geometry (n_g = 3 records).
  std::vector<double> h_vv_, h_gg_, h_vg_[3], b_v_[3], b_g_;
  std::vector<double> step_v_[3], step_g_;
};

}  // namespace relume
