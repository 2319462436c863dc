#include "reduction/methods/light_fit_reducer.h"

#include "core/base/check.h"

namespace relume {
namespace {

std::vector<FittedRecord> as_records(std::span<const SampleMatrix> matrices,
                                     std::span<const TypedRows> rows) {
  std::vector<FittedRecord> records;
  for (size_t t = 0; t < rows.size(); ++t) {
    const auto width = static_cast<size_t>(matrices[t].type->width);
    for (size_t i = 0; i < rows[t].rows(); ++i) {
      const float* vector = rows[t].values.data() + i * width;
      records.push_back({static_cast<int>(t), rows[t].weights[i], {vector, vector + width}});
    }
  }
  return records;
}

}  // namespace

LightFitReducer::LightFitReducer(const TrainingSet& training, const LightFitParams& params)
    : training_(training), params_(params) {
  CHECK(training.validation != nullptr);
}

void LightFitReducer::reduce(std::span<const SampleMatrix> matrices, float weight_per_sample,
                             std::span<const TypedRows> guard, Random& random,
                             SampleTile& records) {
  std::vector<FittedRecord> best = as_records(matrices, guard);
  evaluate_responses(training_.evaluator, matrices, weight_per_sample, responses_);
  std::vector<FittedRecord> fitted =
      light_fit(training_.evaluator, matrices, weight_per_sample, responses_, params_, random);
  if (!fitted.empty()) {
    const LobeEvaluator& validation = training_.validation->evaluator;
    evaluate_responses(validation, matrices, weight_per_sample, responses_);
    if (response_error(validation, fitted, responses_.target) <
        response_error(validation, best, responses_.target)) {
      best = std::move(fitted);
    }
  }
  for (const FittedRecord& record : best) {
    TypedRows& rows = records.types[record.type];
    rows.values.insert(rows.values.end(), record.vector.begin(), record.vector.end());
    rows.weights.push_back(record.weight);
  }
}

}  // namespace relume
