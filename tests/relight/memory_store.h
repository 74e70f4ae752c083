// Keeps what is prepared in memory.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "relight/blob_store.h"

namespace pleinair {

class MemoryStore : public BlobStore {
 public:
  std::optional<Blob> Load(std::string_view key) override {
    const auto found = blobs.find(std::string(key));
    if (found == blobs.end()) return std::nullopt;
    return Blob(found->second);
  }
  void Save(std::string_view key, std::string_view bytes) override {
    blobs[std::string(key)] = std::string(bytes);
  }

  std::map<std::string, std::string> blobs;
};

}  // namespace pleinair
