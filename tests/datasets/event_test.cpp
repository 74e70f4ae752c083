// The log of events: losses are summed over a second, all else stays as it came.
#include "datasets/event.h"

#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::event_test {
namespace {

using namespace std::chrono_literals;

const UtcTime kStart = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} + 10h;

TEST(EventLog, NamesAreWordsAndDifferent) {
  std::set<std::string_view> names;
  for (std::size_t k = 0; k < kEventKinds; ++k) {
    const std::string_view name = NameOf(static_cast<EventKind>(k));
    EXPECT_FALSE(name.empty());
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string_view::npos);
    names.insert(name);
  }
  EXPECT_EQ(names.size(), kEventKinds);
  EXPECT_EQ(NameOf(EventKind::kFrameDropped), "frame-dropped");
  EXPECT_EQ(NameOf(EventKind::kEnded), "ended");
}

TEST(EventLog, LossesWithinASecondAreOneEventOfTheirSum) {
  for (const EventKind kind : {EventKind::kFrameDropped,
                               EventKind::kFrameLost,
                               EventKind::kFrameDamaged,
                               EventKind::kTimestamp,
                               EventKind::kPose}) {
    EventLog log;
    for (int i = 0; i < 30; ++i) log.Add({kStart + i * 33ms, kind, "first", 2});
    log.Add({kStart + 1s, kind, "second"});
    const std::vector<Event> events = log.TakeAll();
    ASSERT_EQ(events.size(), 2u) << NameOf(kind);
    EXPECT_EQ(events[0].count, 60);
    EXPECT_EQ(events[0].time, kStart);
    EXPECT_EQ(events[1].count, 1);
    EXPECT_EQ(events[1].text, "second");
    EXPECT_EQ(log.CountOf(kind), 61);
  }
}

TEST(EventLog, OtherKindsAreNeverSummed) {
  EventLog log;
  for (std::size_t k = 0; k < kEventKinds; ++k) {
    const auto kind = static_cast<EventKind>(k);
    log.Add({kStart, kind, "a"});
    log.Add({kStart, kind, "b"});
  }
  // The five kinds of loss are one event each.
  EXPECT_EQ(log.TakeAll().size(), 2 * kEventKinds - 5);
}

TEST(EventLog, KindsAreSummedApart) {
  EventLog log;
  for (int i = 0; i < 10; ++i) {
    log.Add({kStart + i * 1ms, EventKind::kFrameDropped, "dropped"});
    log.Add({kStart + i * 1ms, EventKind::kFrameLost, "lost", 3});
  }
  const std::vector<Event> events = log.TakeAll();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].count, 10);
  EXPECT_EQ(events[1].count, 30);
}

// A sum that may still grow stays until its second is over.
TEST(EventLog, TakesInOrderWhatIsComplete) {
  EventLog log;
  log.Add({kStart, EventKind::kStarted, "1"});
  log.Add({kStart + 100ms, EventKind::kFrameDropped, "2"});
  log.Add({kStart + 200ms, EventKind::kControl, "3"});
  const std::vector<Event> first = log.Take(kStart + 500ms);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].text, "1");
  EXPECT_EQ(first[1].text, "3");
  log.Add({kStart + 600ms, EventKind::kFrameDropped, "2 again"});
  EXPECT_TRUE(log.Take(kStart + 700ms).empty());
  const std::vector<Event> second = log.Take(kStart + 1100ms);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(second[0].text, "2");
  EXPECT_EQ(second[0].count, 2);
  EXPECT_TRUE(log.TakeAll().empty());
  // What was taken is not added to.
  log.Add({kStart + 700ms, EventKind::kFrameDropped, "3"});
  EXPECT_EQ(log.TakeAll().at(0).count, 1);
  EXPECT_EQ(log.CountOf(EventKind::kFrameDropped), 3);
}

// The system's clock is put back an hour: nothing waits for it.
TEST(EventLog, AClockThatIsPutBackKeepsNothingBack) {
  EventLog log;
  log.Add({kStart, EventKind::kFrameDropped, "before"});
  log.Add({kStart - 1h, EventKind::kFrameDropped, "after"});
  const std::vector<Event> events = log.Take(kStart - 1h + 2s);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].text, "before");
}

// Three hours of losses at 30 frames a second, which somebody takes every second.
TEST(EventLog, LongRunsKeepNothing) {
  EventLog log;
  std::int64_t taken = 0;
  std::size_t lines = 0;
  for (int i = 0; i < 3 * 3600 * 30; ++i) {
    const UtcTime now = kStart + i * 33'333'333ns;
    log.Add({now, EventKind::kFrameDropped, "late"});
    if (i % 30 != 0) continue;
    for (const Event& event : log.Take(now)) {
      taken += event.count;
      ++lines;
    }
  }
  const std::vector<Event> rest = log.TakeAll();
  EXPECT_LE(rest.size(), 2u);
  for (const Event& event : rest) taken += event.count;
  EXPECT_EQ(taken, 3 * 3600 * 30);
  EXPECT_LE(lines, 3u * 3600u);
}

TEST(EventLog, CountsFromManyThreads) {
  EventLog log;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&log] {
      for (int i = 0; i < 1000; ++i) log.Add({kStart, EventKind::kFrameLost, "", 2});
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(log.CountOf(EventKind::kFrameLost), 8000);
  const std::vector<Event> events = log.TakeAll();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].count, 8000);
}

}  // namespace
}  // namespace pleinair::event_test
