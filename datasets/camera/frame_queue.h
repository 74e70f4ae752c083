// A bounded queue between a thread that must not wait and one that may.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

namespace pleinair {

template <typename Item>
class FrameQueue {
 public:
  // Throws std::invalid_argument for a capacity of 0.
  explicit FrameQueue(std::size_t capacity) : capacity_(capacity) {
    if (capacity == 0) throw std::invalid_argument("queue capacity: expected 1 or more, found 0");
  }

  // Never waits: a full queue loses its oldest item, which is returned.
  std::optional<Item> PushOverOldest(Item item) {
    std::optional<Item> oldest;
    {
      const std::lock_guard lock(mutex_);
      if (items_.size() == capacity_) {
        oldest = std::move(items_.front());
        items_.pop_front();
      }
      items_.push_back(std::move(item));
    }
    changed_.notify_all();
    return oldest;
  }

  // Waits for room. False where the queue was closed: the item is lost.
  bool PushWhenRoom(Item item) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return items_.size() < capacity_ || is_closed_; });
    if (is_closed_) return false;
    items_.push_back(std::move(item));
    lock.unlock();
    changed_.notify_all();
    return true;
  }

  // Waits for an item; none once the queue is closed and empty.
  std::optional<Item> Pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !items_.empty() || is_closed_; });
    if (items_.empty()) return std::nullopt;
    std::optional<Item> item = std::move(items_.front());
    items_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return item;
  }

  // Items inside can still be taken out.
  void Close() {
    {
      const std::lock_guard lock(mutex_);
      is_closed_ = true;
    }
    changed_.notify_all();
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> items_;
  bool is_closed_ = false;
};

}  // namespace pleinair
