#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

#include "core/base/error.h"
#include "viewer/session/relight_worker.h"

namespace relume {
namespace {

using namespace std::chrono_literals;

/// What a test sees of a source that the worker owns.
struct Record {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<float> rendered;  // gain of the first light of each request, in order
  bool started = false;
  bool open = true;  // while closed, render() does not return
  bool destroyed = false;

  void set_open(bool value) {
    const std::lock_guard lock(mutex);
    open = value;
    changed.notify_all();
  }
  void wait_started() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return started; });
  }
};

class GatedSource final : public FrameSource {
 public:
  GatedSource(Record& record, std::chrono::milliseconds duration = 0ms)
      : record_(record), duration_(duration) {}
  ~GatedSource() override { record_.destroyed = true; }

  void render(const RelightRequest& request, const std::atomic<bool>&, RelitFrame& frame) override {
    const float gain = request.lights.at(0).gain;
    {
      std::unique_lock lock(record_.mutex);
      record_.started = true;
      record_.changed.notify_all();
      record_.changed.wait(lock, [this] { return record_.open; });
      record_.rendered.push_back(gain);
    }
    std::this_thread::sleep_for(duration_);
    if (gain < 0) throw input_error("light 1", "has a\nnegative gain", "make it positive");
    frame.image = Image(1, 1);
    frame.image.pixels[0] = gain;
  }

 private:
  Record& record_;
  std::chrono::milliseconds duration_;
};

RelightRequest request_of(float gain) {
  RelightRequest request;
  request.lights.resize(1);
  request.lights[0].gain = gain;
  return request;
}

TEST(RelightWorker, FinishesTheRunningFrameAndThenTakesTheLatest) {
  Record record;
  record.open = false;
  RelightWorker worker(std::make_unique<GatedSource>(record));
  worker.submit(request_of(1));
  record.wait_started();
  for (const float gain : {2.0f, 3.0f, 4.0f}) worker.submit(request_of(gain));
  EXPECT_TRUE(worker.busy());
  record.set_open(true);
  worker.wait_idle();
  EXPECT_FALSE(worker.busy());
  EXPECT_EQ(record.rendered, (std::vector<float>{1, 4}));
  EXPECT_EQ(worker.counts().submitted, 4u);
  EXPECT_EQ(worker.counts().superseded, 2u);
  EXPECT_EQ(worker.counts().finished, 2u);

  RelitFrame frame;
  ASSERT_TRUE(worker.take(frame));
  EXPECT_EQ(frame.request.lights[0].gain, 4);
  EXPECT_EQ(frame.image.pixels[0], 4);
  EXPECT_EQ(frame.error, "");
  EXPECT_FALSE(worker.take(frame));
}

TEST(RelightWorker, DeliversFramesWhileRequestsComeFasterThanItCanFollow) {
  Record record;
  RelightWorker worker(std::make_unique<GatedSource>(record, 4ms));
  RelitFrame frame;
  int taken = 0;
  float last_taken = 0;
  float gain = 0;
  const auto end = std::chrono::steady_clock::now() + 400ms;
  while (std::chrono::steady_clock::now() < end) {
    worker.submit(request_of(++gain));
    if (worker.take(frame)) {
      EXPECT_GT(frame.request.lights[0].gain, last_taken) << "frames go back in time";
      last_taken = frame.request.lights[0].gain;
      ++taken;
    }
    std::this_thread::sleep_for(500us);
  }
  EXPECT_GE(taken, 10);
  worker.wait_idle();
  ASSERT_TRUE(worker.take(frame));
  EXPECT_EQ(frame.request.lights[0].gain, gain) << "the last request was lost";
  const WorkerCounts counts = worker.counts();
  EXPECT_EQ(counts.submitted, counts.superseded + counts.finished);
}

/// Renders until it is cancelled, or at once when the gain is above 100.
class PatientSource final : public FrameSource {
 public:
  void render(const RelightRequest& request, const std::atomic<bool>& cancelled,
              RelitFrame& frame) override {
    while (request.lights[0].gain <= 100 && !cancelled) std::this_thread::sleep_for(1ms);
    if (cancelled) throw Error(ErrorKind::cancelled, "stopped");
    frame.image = Image(1, 1);
  }
};

TEST(RelightWorker, AFrameThatMayStopGivesWay) {
  RelightWorker worker(std::make_unique<PatientSource>());
  RelightRequest slow = request_of(1);
  slow.may_stop = true;
  worker.submit(slow);
  worker.submit(request_of(101));
  worker.wait_idle();
  RelitFrame frame;
  ASSERT_TRUE(worker.take(frame));
  EXPECT_EQ(frame.request.lights[0].gain, 101);
  EXPECT_EQ(frame.error, "");
  EXPECT_FALSE(worker.take(frame));
  const WorkerCounts counts = worker.counts();
  EXPECT_EQ(counts.finished, 1u);
  EXPECT_EQ(counts.stopped + counts.superseded, 1u);
}

TEST(RelightWorker, StopEndsWhatMayStop) {
  RelightWorker worker(std::make_unique<PatientSource>());
  RelightRequest slow = request_of(1);
  slow.may_stop = true;
  worker.submit(slow);
  worker.stop();
  worker.wait_idle();
  RelitFrame frame;
  EXPECT_FALSE(worker.take(frame));
  worker.submit(slow);  // ended by the destructor
}

TEST(RelightWorker, CarriesAFailureAsOneLineAndGoesOn) {
  Record record;
  RelightWorker worker(std::make_unique<GatedSource>(record));
  RelitFrame frame;
  worker.submit(request_of(-1));
  worker.wait_idle();
  ASSERT_TRUE(worker.take(frame));
  EXPECT_NE(frame.error.find("light 1"), std::string::npos) << frame.error;
  EXPECT_EQ(frame.error.find('\n'), std::string::npos) << frame.error;
  worker.submit(request_of(2));
  worker.wait_idle();
  ASSERT_TRUE(worker.take(frame));
  EXPECT_EQ(frame.error, "");
}

TEST(RelightWorker, FinishesTheRunningFrameOnlyWhenDestroyed) {
  Record record;
  record.open = false;
  std::thread opener;
  {
    RelightWorker worker(std::make_unique<GatedSource>(record));
    worker.submit(request_of(1));
    record.wait_started();
    worker.submit(request_of(2));
    opener = std::thread([&record] {
      std::this_thread::sleep_for(20ms);
      record.set_open(true);
    });
  }
  opener.join();
  EXPECT_EQ(record.rendered, (std::vector<float>{1}));
  EXPECT_TRUE(record.destroyed);
}

TEST(RelightWorker, NotifiesAfterEachFrameUntilTold) {
  Record record;
  RelightWorker worker(std::make_unique<GatedSource>(record));
  std::atomic<int> calls = 0;
  worker.set_notify([&calls] { ++calls; });
  worker.submit(request_of(1));
  while (calls == 0) std::this_thread::sleep_for(1ms);
  worker.set_notify({});
  worker.submit(request_of(2));
  worker.wait_idle();
  std::this_thread::sleep_for(10ms);
  EXPECT_EQ(calls, 1);
}

TEST(RelightWorker, SurvivesManyThreadsAtOnce) {
  Record record;
  RelightWorker worker(std::make_unique<GatedSource>(record));
  std::atomic<uint64_t> taken = 0;
  std::atomic<uint64_t> notified = 0;
  worker.set_notify([&notified] { ++notified; });
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&worker, &taken, t] {
      RelitFrame frame;
      for (int i = 0; i < 300; ++i) {
        worker.submit(request_of(static_cast<float>(1 + t * 1000 + i)));
        if (worker.take(frame)) ++taken;
        if (i % 50 == 0) worker.wait_idle();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  worker.wait_idle();
  const WorkerCounts counts = worker.counts();
  EXPECT_EQ(counts.submitted, 1200u);
  EXPECT_EQ(counts.submitted, counts.superseded + counts.finished);
  EXPECT_EQ(record.rendered.size(), counts.finished);
  EXPECT_LE(taken, counts.finished);
  EXPECT_GT(taken, 0u);
}

}  // namespace
}  // namespace relume
