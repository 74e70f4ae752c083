// Bytes that a long run needs at its end alone: in a file, and not in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "apps/descriptor.h"

namespace pleinair {

// A report's pictures are up to 28 MB, and half of that after they were thinned out: memory would
// rise and fall by it as long as a run lasts. They are in memory where the disk is nearly full:
// the room is for what the run leaves.
class SetAside {
 public:
  struct Place {
    std::int64_t offset = 0;
    std::int64_t bytes = 0;
  };

  // The file is in `folder`, has no name, and is gone with the process. `keep_free_bytes` of the
  // disk stay free, as recordings leave it. Throws std::runtime_error naming the folder, as Read.
  explicit SetAside(std::filesystem::path folder, std::uint64_t keep_free_bytes = 200'000'000);

  Place Add(const std::string& bytes);
  std::string Read(const Place& place) const;
  // Forgets all others, and moves these together. In the order in which they were added.
  void KeepOnly(std::span<Place* const> places);
  std::int64_t Bytes() const { return end_; }

  bool IsInMemory() const { return is_in_memory_; }
  // Where the disk is nearly full, it gets back all that the file takes of it, also what was held
  // from the start: so a report without pictures fits on a disk that the run has filled.
  void LeaveRoom();

 private:
  bool HasRoom(std::uint64_t bytes) const;
  void Hold() const;
  void MoveToMemory();
  void Write(const std::string& bytes);

  std::filesystem::path folder_;
  std::uint64_t keep_free_bytes_;
  Descriptor file_;
  bool is_in_memory_ = false;
  std::string memory_;
  std::int64_t end_ = 0;
};

}  // namespace pleinair
