// Bytes that a long run needs at its end alone: in a file, and not in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace pleinair {

// A report's pictures are up to 28 MB, and half of that after they were thinned out: memory would
// rise and fall by it as long as a run lasts.
class SetAside {
 public:
  struct Place {
    std::int64_t offset = 0;
    std::int64_t bytes = 0;
  };

  // The file is in `folder`, has no name, and is gone with the process. Throws std::runtime_error
  // naming the folder; so do the others.
  explicit SetAside(std::filesystem::path folder);

  Place Add(const std::string& bytes);
  std::string Read(const Place& place) const;
  // Forgets all others, and moves these together. In the order in which they were added.
  void KeepOnly(std::span<Place* const> places);
  std::int64_t Bytes() const { return end_; }

 private:
  void Write(const std::string& bytes);

  std::filesystem::path folder_;
  mutable std::fstream file_;
  std::int64_t end_ = 0;
};

}  // namespace pleinair
