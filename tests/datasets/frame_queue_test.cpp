// The queue between a camera and its consumer.
#include "datasets/camera/frame_queue.h"

#include <algorithm>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::frame_queue_test {
namespace {

TEST(FrameQueue, GivesItemsInTheOrderInWhichTheyCame) {
  FrameQueue<int> queue(5);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(queue.PushOverOldest(i));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(queue.Pop(), i);
}

TEST(FrameQueue, AFullOneLosesItsOldest) {
  FrameQueue<int> queue(2);
  EXPECT_FALSE(queue.PushOverOldest(1));
  EXPECT_FALSE(queue.PushOverOldest(2));
  EXPECT_EQ(queue.PushOverOldest(3), 1);
  EXPECT_EQ(queue.PushOverOldest(4), 2);
  EXPECT_EQ(queue.Pop(), 3);
  EXPECT_EQ(queue.Pop(), 4);
}

// Each item that nobody takes is handed back: none is kept beyond the capacity.
TEST(FrameQueue, HoldsNoMoreThanItsCapacityOverManyPushes) {
  constexpr int kPushes = 10'000;
  const auto counted = std::make_shared<int>(0);
  FrameQueue<std::shared_ptr<int>> queue(3);
  int lost = 0;
  for (int i = 0; i < kPushes; ++i) {
    lost += queue.PushOverOldest(counted) ? 1 : 0;
    ASSERT_LE(counted.use_count(), 1 + 3);
  }
  EXPECT_EQ(lost, kPushes - 3);
}

TEST(FrameQueue, TakesItemsThatCannotBeCopied) {
  FrameQueue<std::unique_ptr<int>> queue(1);
  queue.PushOverOldest(std::make_unique<int>(7));
  EXPECT_EQ(**queue.Pop(), 7);
}

TEST(FrameQueue, WhatIsInAClosedOneCanStillBeTaken) {
  FrameQueue<int> queue(2);
  queue.PushOverOldest(1);
  queue.Close();
  EXPECT_FALSE(queue.PushWhenRoom(2));
  EXPECT_EQ(queue.Pop(), 1);
  EXPECT_FALSE(queue.Pop());
  EXPECT_FALSE(queue.Pop()) << "and stays closed";
}

TEST(FrameQueue, ClosingEndsThoseWhoWait) {
  FrameQueue<int> empty(1);
  FrameQueue<int> full(1);
  full.PushOverOldest(1);
  auto reader = std::async(std::launch::async, [&] { return empty.Pop().has_value(); });
  auto writer = std::async(std::launch::async, [&] { return full.PushWhenRoom(2); });
  empty.Close();
  full.Close();
  EXPECT_FALSE(reader.get());
  EXPECT_FALSE(writer.get());
}

// All that several threads push with room reaches several readers, once each, and in each writer's
// order at each reader.
TEST(FrameQueue, LosesNothingBetweenThreadsThatWait) {
  constexpr int kWriters = 3;
  constexpr int kReaders = 2;
  constexpr int kItems = 2000;
  FrameQueue<std::pair<int, int>> queue(4);
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&queue, w] {
      for (int i = 0; i < kItems; ++i) EXPECT_TRUE(queue.PushWhenRoom({w, i}));
    });
  }
  std::vector<std::vector<std::pair<int, int>>> read(kReaders);
  std::vector<std::thread> readers;
  for (auto& own : read) {
    readers.emplace_back([&queue, &own] {
      while (const auto item = queue.Pop()) own.push_back(*item);
    });
  }
  for (std::thread& writer : writers) writer.join();
  queue.Close();
  for (std::thread& reader : readers) reader.join();
  std::vector<std::vector<int>> seen(kWriters, std::vector<int>(kItems, 0));
  for (const auto& own : read) {
    std::vector<int> last(kWriters, -1);
    for (const auto& [w, i] : own) {
      EXPECT_GT(i, last[static_cast<std::size_t>(w)]);
      last[static_cast<std::size_t>(w)] = i;
      ++seen[static_cast<std::size_t>(w)][static_cast<std::size_t>(i)];
    }
  }
  for (const auto& of_writer : seen) EXPECT_EQ(of_writer, std::vector<int>(kItems, 1));
}

// A camera that never waits: what its reader does not get was handed back, and the rest is in
// order.
TEST(FrameQueue, CountsWhatASlowReaderLoses) {
  constexpr int kItems = 10'000;
  FrameQueue<int> queue(2);
  int lost = 0;
  std::vector<int> read;
  std::thread reader([&] {
    while (const auto item = queue.Pop()) read.push_back(*item);
  });
  for (int i = 0; i < kItems; ++i) lost += queue.PushOverOldest(i) ? 1 : 0;
  queue.Close();
  reader.join();
  EXPECT_EQ(lost + static_cast<int>(read.size()), kItems);
  EXPECT_TRUE(std::is_sorted(read.begin(), read.end()));
  EXPECT_EQ(read.back(), kItems - 1);
}

TEST(FrameQueue, RefusesToHoldNothing) { EXPECT_THROW(FrameQueue<int>(0), std::invalid_argument); }

}  // namespace
}  // namespace pleinair::frame_queue_test
