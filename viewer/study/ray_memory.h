#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/shade/light_matrix.h"
#include "shadow/traced.h"

namespace relume {

/// Lights that shadow rays go to, told apart by their names. Const use is thread-safe.
class RayTargets {
 public:
  /// Keeps a reference to `tracer`.
  explicit RayTargets(const Tracer& tracer) : tracer_(tracer) {}

  /// Does nothing for a light that is there already.
  void add(const Light& light);

  /// The index of a light that was added.
  size_t find(const Light& light) const { return by_name_.at(light.name); }
  const TracedVisibility& rays(size_t light) const { return *rays_[light]; }
  size_t count() const { return rays_.size(); }

 private:
  const Tracer& tracer_;
  std::vector<std::unique_ptr<TracedVisibility>> rays_;
  std::unordered_map<std::string, size_t> by_name_;
};

/// What shadow rays found for the receivers of one tile: equal receivers, for instance a sample and
/// a record that kept its place, are traced once for each light. Used from one thread. Keeps a byte
/// a receiver and light.
class RayMemory {
 public:
  /// `targets` must outlive it; none may be added meanwhile.
  explicit RayMemory(const RayTargets& targets);

  /// Per column, a source that answers from this memory, for one thread; null for padding and for
  /// lights that cast no shadow. All others must be targets. Valid as long as the memory.
  std::vector<const VisibilitySource*> sources(const LightSet& lights) const;

  RayMemory(const RayMemory&) = delete;
  RayMemory& operator=(const RayMemory&) = delete;

  /// The same as targets.rays(light).visibility(receivers, visibility), bit by bit.
  void visibility(size_t light, const Receivers& receivers, float* visibility);

  /// How many answers were not known yet.
  uint64_t traced_count() const { return traced_count_; }

 private:
  enum class Answer : uint8_t { unknown, hidden, seen };

  /// All that a shadow ray depends on, as bits.
  struct Key {
    uint32_t bits[8];
    bool operator==(const Key&) const = default;
  };
  struct KeyHash {
    size_t operator()(const Key& key) const;
  };

  /// One light's visibility.
  class Source final : public VisibilitySource {
   public:
    Source(RayMemory& memory, size_t light) : memory_(memory), light_(light) {}

    void prepare(const Light&) override {}  // its target is
    void visibility(const Receivers& receivers, float* visibility) const override {
      memory_.visibility(light_, receivers, visibility);
    }

   private:
    RayMemory& memory_;
    size_t light_;
  };

  void find_rows(const Receivers& receivers);
  Answer trace(size_t light, const Receivers& receivers, int index) const;

  const RayTargets& targets_;
  std::vector<Source> sources_;  ///< one a target
  std::unordered_map<Key, uint32_t, KeyHash> row_of_;
  std::vector<Answer> answers_;  ///< row * lights + light
  std::vector<Key> keys_;        ///< of the receivers that were asked about last
  std::vector<Key> next_keys_;
  std::vector<uint32_t> rows_;  ///< theirs
  uint64_t traced_count_ = 0;
};

}  // namespace relume
