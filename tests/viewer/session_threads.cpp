// From the scene to the frame: the same bytes for any number of threads, again and again, and after
// work that was cancelled at any moment.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/base/timer.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "viewer/session/frame_source.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

PrepareParams small_params(ReductionMethod method) {
  PrepareParams params;
  params.spp = 9;
  params.width = 36;
  params.height = 36;
  params.reduction.method = method;
  params.reduction.records = 3;
  params.reduction.stored_members = 255;
  params.training.lights = 16;
  return params;
}

const Scene& hair() {
  static const Scene scene = load_scene("hair", shader_table(), {});
  return scene;
}

const Tracer& hair_tracer() {
  static const Tracer tracer(hair());
  return tracer;
}

std::vector<std::byte> prepared_bytes(ReductionMethod method) {
  const RelightCache cache = prepare_in_memory(hair(), hair_tracer(), small_params(method), {});
  return {cache.bytes().begin(), cache.bytes().end()};
}

class Threads : public testing::Test {
 protected:
  ~Threads() override { set_thread_count(0); }
};

class PreparedOnThreads : public Threads, public testing::WithParamInterface<ReductionMethod> {};

TEST_P(PreparedOnThreads, CachesAreTheSameToTheByte) {
  std::vector<std::byte> first;
  for (const int threads : {1, 2, 4, 8, 8}) {
    set_thread_count(threads);
    std::vector<std::byte> bytes = prepared_bytes(GetParam());
    if (first.empty())
      first = std::move(bytes);
    else
      EXPECT_TRUE(bytes == first) << threads << " threads";
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, PreparedOnThreads, testing::ValuesIn([] {
                           std::vector<ReductionMethod> methods;
                           for (const auto& label : reduction_method_labels) {
                             methods.push_back(label.value);
                           }
                           return methods;
                         }()),
                         [](const auto& method) {
                           std::string name(label_of(reduction_method_labels, method.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

class RelitOnThreads : public Threads, public testing::WithParamInterface<ShadowMethod> {
 protected:
  Image render() const {
    const Tracer tracer(hair());
    const auto source = make_cache_source(
        prepare_in_memory(hair(), tracer, small_params(ReductionMethod::kmeans), {}), &tracer);
    RelightRequest request;
    request.lights = hair().lights;
    request.shadows = GetParam();
    RelitFrame frame;
    const std::atomic<bool> never{false};
    source->render(request, never, frame);
    return frame.image;
  }
};

TEST_P(RelitOnThreads, FramesAreTheSameToTheByte) {
  Image first;
  for (const int threads : {1, 2, 4, 8, 8}) {
    set_thread_count(threads);
    const Image image = render();
    if (first.pixels.empty()) first = image;
    EXPECT_TRUE(image.pixels == first.pixels) << threads << " threads";
  }
}

INSTANTIATE_TEST_SUITE_P(Shadows, RelitOnThreads,
                         testing::Values(ShadowMethod::none, ShadowMethod::ray,
                                         ShadowMethod::members, ShadowMethod::coverage,
                                         ShadowMethod::opacity, ShadowMethod::volume),
                         [](const auto& method) {
                           return std::string(label_of(shadow_method_labels, method.param));
                         });

/// Moves the lights, cancels the frame from another thread at random moments, and finishes another
/// one: it must be what a source without a history gives. Counts in `finished` when all was so.
void drag_and_cancel(const std::filesystem::path& cache, ShadowMethod shadows, uint64_t seed,
                     std::atomic<int>& finished) {
  const auto make_source = [&] {
    return make_cache_source(RelightCache::open(cache, shader_table()), &hair_tracer());
  };
  const auto source = make_source();
  Random random(seed, RandomStream::tests, 0);
  RelightRequest request;
  request.lights = hair().lights;
  request.shadows = shadows;
  RelitFrame frame;
  const std::atomic<bool> never{false};
  const Timer timer;
  source->render(request, never, frame);
  const double whole_ms = timer.ms();
  const int moves = shadows == ShadowMethod::coverage ? 3 : 12;
  for (int i = 0; i < moves; ++i) {
    for (Light& light : request.lights) light.position.x += random.uniform(-0.3f, 0.3f);
    request.dragging = i % 2 == 0;
    std::atomic<bool> cancelled{i == 0};  // the first one certainly
    std::thread person([&, pause_ms = random.uniform(0, 1.2f) * whole_ms] {
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(pause_ms));
      cancelled = true;
    });
    try {
      source->render(request, cancelled, frame);
      EXPECT_GT(i, 0) << "cannot be cancelled";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled) << error.what();
    }
    person.join();
    request.dragging = false;
    source->render(request, never, frame);
    RelitFrame fresh;
    make_source()->render(request, never, fresh);
    ASSERT_TRUE(frame.image.pixels == fresh.image.pixels) << "seed " << seed << ", move " << i;
  }
  ++finished;
}

class Cancelled : public testing::TestWithParam<ShadowMethod> {};

TEST_P(Cancelled, AtAnyMomentUnderLoadNothingIsWrongAfterwards) {
  const test::TemporaryFolder folder;
  const auto cache = folder.file("a.relume");
  prepare_to_file(hair(), hair_tracer(), small_params(ReductionMethod::kmeans), cache, {});
  std::atomic<int> finished{0};
  std::vector<std::thread> people;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    people.emplace_back([&, seed] { drag_and_cancel(cache, GetParam(), seed, finished); });
  }
  for (std::thread& person : people) person.join();
  EXPECT_EQ(finished, 3);
}

INSTANTIATE_TEST_SUITE_P(Shadows, Cancelled,
                         testing::Values(ShadowMethod::none, ShadowMethod::ray,
                                         ShadowMethod::members, ShadowMethod::coverage),
                         [](const auto& method) {
                           return std::string(label_of(shadow_method_labels, method.param));
                         });

/// Stops `prepare` at each of its reports in turn: nothing new may stand in the folder.
TEST(CancelledPrepare, LeavesTheFolderAsItWas) {
  const test::TemporaryFolder folder;
  const auto path = folder.file("a.relume");
  PrepareParams params = small_params(ReductionMethod::kmeans);
  params.width = params.height = 96;
  bool is_complete = false;
  int stopped = 0;
  for (int last = 0; !is_complete; ++last) {
    test::write_all(path, "old");
    int reports = 0;
    try {
      prepare_to_file(hair(), hair_tracer(), params, path,
                      [&](const std::string&, double, double) { return reports++ < last; });
      is_complete = true;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled) << error.what();
      EXPECT_EQ(test::read_all(path), "old") << "report " << last;
      ++stopped;
    }
    EXPECT_EQ(folder.entry_count(), 1u) << "report " << last;
  }
  EXPECT_GT(stopped, 0);
  EXPECT_NE(test::read_all(path), "old");
}

}  // namespace
}  // namespace relume
