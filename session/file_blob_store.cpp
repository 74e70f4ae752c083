#include "session/file_blob_store.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <pwd.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xxhash.h>

#include "scene/write_all.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "pleinair blob 1 ";
constexpr std::size_t kChecksumDigits = 32;
constexpr std::size_t kHeaderBytes = kMagic.size() + kChecksumDigits + 1;
constexpr std::size_t kLongestKey = 128;
// A file under a temporary name is being written, or was left by a run that was cut off. No write
// takes this long.
constexpr std::chrono::hours kTemporaryFileLife{1};

// The key goes into the checksum, so that a file under another's name is refused.
std::string Checksum(std::string_view key, std::string_view bytes) {
  XXH3_state_t* state = XXH3_createState();
  XXH3_128bits_reset(state);
  XXH3_128bits_update(state, key.data(), key.size());
  XXH3_128bits_update(state, "\n", 1);
  XXH3_128bits_update(state, bytes.data(), bytes.size());
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state));
  XXH3_freeState(state);
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    constexpr std::string_view kHexDigits = "0123456789abcdef";
    text += kHexDigits[byte >> 4U];
    text += kHexDigits[byte & 15U];
  }
  return text;
}

std::string Header(std::string_view key, std::string_view bytes) {
  return std::string(kMagic) + Checksum(key, bytes) + '\n';
}

std::string LastSystemError() { return std::generic_category().message(errno); }

// Room for so many bytes, handed out at once; none where there is not enough memory. A string is
// filled with zeros first, and each of its pages costs a fault, which together takes longer than
// reading a file into it.
std::shared_ptr<char> NewPages(std::size_t size) {
  void* const start = mmap(
      nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (start == MAP_FAILED) return nullptr;
  return {static_cast<char*>(start), [size](char* pages) { munmap(pages, size); }};
}

bool IsKeyCharacter(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
         c == '_';
}

}  // namespace

fs::path DefaultCacheFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && fs::path(cache).is_absolute()) {
    return fs::path(cache) / "pleinair";
  }
  const char* home = std::getenv("HOME");
  if (!home || !*home) {
    const passwd* user = getpwuid(getuid());
    home = user ? user->pw_dir : nullptr;
  }
  if (!home || !*home) {
    throw std::runtime_error("no cache folder: neither XDG_CACHE_HOME nor HOME is set");
  }
  return fs::path(home) / ".cache" / "pleinair";
}

FileBlobStore::FileBlobStore(fs::path folder, std::uint64_t limit_bytes)
    : folder_(folder.empty() ? DefaultCacheFolder() : std::move(folder)),
      limit_bytes_(limit_bytes) {}

fs::path FileBlobStore::PathOf(std::string_view key) const {
  if (key.empty() || key.size() > kLongestKey ||
      !std::all_of(key.begin(), key.end(), IsKeyCharacter)) {
    throw std::invalid_argument("blob key '" + std::string(key) +
                                "': expected 1 to 128 letters, digits, '-' and '_'");
  }
  return folder_ / (std::string(key) + ".blob");
}

std::optional<Blob> FileBlobStore::Load(std::string_view key) {
  const fs::path path = PathOf(key);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return std::nullopt;
  if (!fs::is_regular_file(status)) {
    fs::remove_all(path, error);
    return std::nullopt;
  }
  // The size is that of the open file: another process may have replaced the file by now.
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return std::nullopt;
  const std::streamoff file_bytes = file.tellg();
  file.seekg(0);

  // Save writes nothing larger than the limit: such a file might not even fit into memory.
  if (file_bytes >= static_cast<std::streamoff>(kHeaderBytes) &&
      static_cast<std::uint64_t>(file_bytes) <= limit_bytes_) {
    const auto size = static_cast<std::size_t>(file_bytes);
    const std::shared_ptr<char> buffer = NewPages(size);
    if (!buffer) return std::nullopt;
    file.read(buffer.get(), file_bytes);
    const std::string_view whole(buffer.get(), size);
    const std::string_view bytes = whole.substr(kHeaderBytes);
    if (file && whole.starts_with(Header(key, bytes))) {
      // The time of last use, which decides eviction. Where it cannot be set, the time of writing
      // replaces it.
      fs::last_write_time(path, fs::file_time_type::clock::now(), error);
      return Blob(buffer, bytes);
    }
  }
  fs::remove(path, error);
  return std::nullopt;
}

void FileBlobStore::Save(std::string_view key, std::string_view bytes) {
  const fs::path path = PathOf(key);
  save_failure_.clear();
  if (bytes.size() + kHeaderBytes > limit_bytes_) {
    save_failure_ = path.string() + ": not kept: " + std::to_string(bytes.size()) +
                    " bytes exceed the cache's limit of " + std::to_string(limit_bytes_);
    return;
  }
  std::error_code error;
  fs::create_directories(folder_, error);
  std::string temporary = (folder_ / (std::string(key) + ".XXXXXX.part")).string();
  const int file = mkostemps(temporary.data(), 5, O_CLOEXEC);  // 5: the length of ".part".
  if (file < 0) {
    save_failure_ = folder_.string() + ": not writable: " + LastSystemError();
    return;
  }
  const bool written = WriteAll(file, Header(key, bytes)) && WriteAll(file, bytes);
  if (!written) save_failure_ = temporary + ": not written: " + LastSystemError();
  if (close(file) != 0 && written) {
    save_failure_ = temporary + ": not written: " + LastSystemError();
  }
  if (save_failure_.empty()) {
    fs::rename(temporary, path, error);
    if (error) save_failure_ = path.string() + ": not replaced: " + error.message();
  }
  if (!save_failure_.empty()) {
    fs::remove(temporary, error);
    return;
  }
  RemoveLeastRecentlyUsed(path);
}

void FileBlobStore::RemoveLeastRecentlyUsed(const fs::path& keep) const {
  struct Kept {
    fs::file_time_type last_use;
    fs::path path;
    std::uintmax_t bytes;
  };
  std::vector<Kept> blobs;
  std::uintmax_t total_bytes = 0;
  std::error_code error;
  // Other processes add and remove files meanwhile: files that are gone do not count.
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code gone;
    const fs::path& path = entry->path();
    const fs::file_time_type last_use = entry->last_write_time(gone);
    if (gone || !entry->is_regular_file(gone)) continue;
    if (path.extension() == ".part") {
      if (fs::file_time_type::clock::now() - last_use > kTemporaryFileLife) fs::remove(path, gone);
    } else if (path.extension() == ".blob") {
      const std::uintmax_t bytes = entry->file_size(gone);
      if (gone) continue;
      total_bytes += bytes;
      if (path != keep) blobs.push_back({last_use, path, bytes});
    }
  }
  std::sort(blobs.begin(), blobs.end(), [](const Kept& a, const Kept& b) {
    return std::pair(a.last_use, a.path) < std::pair(b.last_use, b.path);
  });
  for (const Kept& blob : blobs) {
    if (total_bytes <= limit_bytes_) break;
    if (fs::remove(blob.path, error)) total_bytes -= blob.bytes;
  }
}

}  // namespace pleinair
