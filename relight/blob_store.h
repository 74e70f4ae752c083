// Where prepared parts are kept between runs.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace pleinair {

// A store of blobs by content key. An implementation may keep nothing.
class BlobStore {
 public:
  virtual ~BlobStore() = default;
  virtual std::optional<std::string> Load(std::string_view key) = 0;
  // Stores completely or not at all; a failure to store is not an error for the caller.
  virtual void Save(std::string_view key, std::string_view bytes) = 0;
};

class KeepsNothing final : public BlobStore {
 public:
  std::optional<std::string> Load(std::string_view) override { return std::nullopt; }
  void Save(std::string_view, std::string_view) override {}
};

}  // namespace pleinair
