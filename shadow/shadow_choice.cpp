#include "shadow/shadow_choice.h"

#include <fmt/format.h>

#include <limits>

namespace relume {
namespace {

constexpr double keep_share = 0.8;  ///< of the budget, that a method not in use must fit

/// About a move's time as a multiple of volume's: hair, docs/shadows.md. Only until it is measured.
double typical_cost(ShadowMethod method) {
  switch (method) {
    case ShadowMethod::none:
      return 0;
    case ShadowMethod::volume:
      return 1;
    case ShadowMethod::opacity:
      return 3;
    case ShadowMethod::coverage:
      return 8;
    case ShadowMethod::ray:
      return 15;
    case ShadowMethod::members:
    case ShadowMethod::automatic:
      return 40;
  }
  return 1;
}

std::string_view name_of(ShadowMethod method) {
  return label_of(shadow_method_labels, method);
}

}  // namespace

double ShadowChooser::expected_ms(ShadowMethod method) const {
  if (const auto own = times_ms_.find(method); own != times_ms_.end()) return own->second;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [timed, ms] : times_ms_) {
    if (typical_cost(timed) > 0) {
      least = std::min(least, ms * typical_cost(method) / typical_cost(timed));
    }
  }
  return least;
}

ShadowChoice ShadowChooser::choose(ShadowLevel level, double budget_ms) {
  const ShadowMethod exact = content_.has_members ? ShadowMethod::members : ShadowMethod::ray;
  if (level == ShadowLevel::final) {
    return {exact, fmt::format("{}: traced, whatever it takes", name_of(exact))};
  }
  if (!content_.has_thin_geometry) return {ShadowMethod::ray, "ray: solids only"};
  const auto choice = [&](ShadowMethod method, const std::string& why) {
    last_[level] = method;
    return ShadowChoice{method, fmt::format("{}: {}", name_of(method), why)};
  };
  for (const ShadowMethod method : {ShadowMethod::coverage, ShadowMethod::opacity}) {
    const auto last = last_.find(level);
    const bool in_use = last != last_.end() && last->second == method;
    const double ms = expected_ms(method);
    if (!(ms <= budget_ms * (in_use ? 1 : keep_share))) continue;
    return choice(method, fmt::format("{:.0f} of {:.0f} ms", ms, budget_ms));
  }
  const double ms = expected_ms(ShadowMethod::volume);
  if (!times_ms_.contains(ShadowMethod::volume)) {
    return choice(ShadowMethod::volume, "nothing timed yet");
  }
  return choice(ShadowMethod::volume, fmt::format("{:.0f} of {:.0f} ms", ms, budget_ms));
}

void ShadowChooser::add_time(ShadowMethod method, double ms) {
  const auto [known, is_new] = times_ms_.emplace(method, ms);
  if (!is_new) known->second = 0.5 * (known->second + ms);
}

}  // namespace relume
