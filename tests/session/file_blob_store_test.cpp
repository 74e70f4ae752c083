#include "session/file_blob_store.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace pleinair::file_blob_store_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kKey = "0123456789abcdef";
const std::string kOtherKey = "fedcba9876543210";

class FileBlobStoreTest : public ::testing::Test {
 protected:
  FileBlobStoreTest() {
    std::string pattern = (fs::temp_directory_path() / "pleinair-blobs-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~FileBlobStoreTest() override { fs::remove_all(folder_); }

  FileBlobStore Store(std::uint64_t limit_bytes = 1U << 20U) const {
    return FileBlobStore(folder_ / "cache", limit_bytes);
  }
  fs::path BlobPath(const std::string& key) const { return folder_ / "cache" / (key + ".blob"); }

  // Moves the last use of a blob into the past: the clock of files is too coarse to separate two
  // writes in a row.
  void Age(const fs::path& path, std::chrono::minutes age) const {
    fs::last_write_time(path, fs::file_time_type::clock::now() - age);
  }

  fs::path folder_;
};

TEST_F(FileBlobStoreTest, GivesBackWhatWasSaved) {
  const std::string bytes("with\0zero and \xff", 15);
  Store().Save(kKey, bytes);
  EXPECT_EQ(Store().Load(kKey), bytes);
  Store().Save(kKey, "new");
  EXPECT_EQ(Store().Load(kKey), "new");
  Store().Save(kKey, "");
  EXPECT_EQ(Store().Load(kKey), "");
}

TEST_F(FileBlobStoreTest, HasNothingUnderAKeyNeverSaved) {
  EXPECT_EQ(Store().Load(kKey), std::nullopt);
  EXPECT_FALSE(fs::exists(folder_ / "cache"));
}

TEST_F(FileBlobStoreTest, TakesADamagedBlobForAbsentAndRemovesIt) {
  FileBlobStore store = Store();
  const std::string bytes = "the prepared courtyard";
  store.Save(kKey, bytes);
  std::string whole(fs::file_size(BlobPath(kKey)), '\0');
  std::ifstream(BlobPath(kKey), std::ios::binary)
      .read(whole.data(), static_cast<std::streamsize>(whole.size()));

  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 1);
    std::ofstream(BlobPath(kKey), std::ios::binary) << flipped;
    EXPECT_EQ(store.Load(kKey), std::nullopt) << "bit flipped in byte " << at;
    EXPECT_FALSE(fs::exists(BlobPath(kKey)));
    std::ofstream(BlobPath(kKey), std::ios::binary) << whole.substr(0, at);
    EXPECT_EQ(store.Load(kKey), std::nullopt) << "cut off after byte " << at;
  }
  std::ofstream(BlobPath(kKey), std::ios::binary) << whole << "x";
  EXPECT_EQ(store.Load(kKey), std::nullopt);
  std::ofstream(BlobPath(kKey), std::ios::binary) << whole;
  EXPECT_EQ(store.Load(kKey), bytes);
}

// Where a blob should be: a folder, a pipe that nothing writes to, a file larger than memory.
TEST_F(FileBlobStoreTest, ReplacesWhatIsNoBlob) {
  FileBlobStore store = Store();
  store.Save(kKey, "bytes");
  const fs::path path = BlobPath(kKey);
  const auto expect_replaced = [&] {
    EXPECT_EQ(store.Load(kKey), std::nullopt);
    EXPECT_FALSE(fs::exists(path));
    store.Save(kKey, "bytes");
    EXPECT_EQ(store.SaveFailure(), "");
    EXPECT_EQ(store.Load(kKey), "bytes");
    fs::remove(path);
  };
  fs::remove(path);
  fs::create_directories(path / "inner");
  expect_replaced();
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  expect_replaced();
  std::ofstream(path) << "x";
  fs::resize_file(path, std::uintmax_t{1} << 42U);  // No block of it is written.
  expect_replaced();
}

TEST_F(FileBlobStoreTest, DoesNotTakeAnotherKeysFileForItsOwn) {
  FileBlobStore store = Store();
  store.Save(kKey, "bytes");
  fs::rename(BlobPath(kKey), BlobPath(kOtherKey));
  EXPECT_EQ(store.Load(kOtherKey), std::nullopt);
}

TEST_F(FileBlobStoreTest, LeavesNoTemporaryFile) {
  Store().Save(kKey, "bytes");
  const auto files = std::distance(fs::directory_iterator(folder_ / "cache"), {});
  EXPECT_EQ(files, 1);
}

TEST_F(FileBlobStoreTest, ClearsAwayWhatARunThatWasCutOffLeft) {
  FileBlobStore store = Store();
  store.Save(kKey, "bytes");
  const fs::path old = folder_ / "cache" / "0a.abcdef.part";
  const fs::path fresh = folder_ / "cache" / "0b.abcdef.part";
  std::ofstream(old) << "half";
  std::ofstream(fresh) << "half";
  Age(old, std::chrono::minutes(61));
  store.Save(kOtherKey, "bytes");
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(fresh));
}

TEST_F(FileBlobStoreTest, DropsTheLeastRecentlyUsedAboveTheLimit) {
  const std::string bytes(1000, 'x');
  FileBlobStore store = Store(3300);  // Room for three, with their headers of about 50 bytes.
  for (const std::string key : {"a", "b", "c"}) store.Save(key, bytes);
  Age(BlobPath("a"), std::chrono::minutes(3));
  Age(BlobPath("b"), std::chrono::minutes(2));
  Age(BlobPath("c"), std::chrono::minutes(1));
  EXPECT_EQ(store.Load("a"), bytes);  // Used just now: "b" is the oldest from here on.
  store.Save("d", bytes);
  EXPECT_EQ(store.Load("b"), std::nullopt);
  EXPECT_EQ(store.Load("a"), bytes);
  EXPECT_EQ(store.Load("c"), bytes);
  EXPECT_EQ(store.Load("d"), bytes);
}

TEST_F(FileBlobStoreTest, NeverRemovesFilesThatAreNotItsOwn) {
  FileBlobStore store = Store(200);
  store.Save("a", "bytes");
  const fs::path letter = folder_ / "cache" / "letter.txt";
  std::ofstream(letter) << std::string(1000, 'x');
  Age(letter, std::chrono::hours(48));
  store.Save("b", std::string(100, 'x'));
  EXPECT_TRUE(fs::exists(letter));
}

TEST_F(FileBlobStoreTest, KeepsNothingThatExceedsTheLimitAlone) {
  FileBlobStore store = Store(1000);
  store.Save(kKey, "small");
  store.Save(kOtherKey, std::string(1000, 'x'));
  EXPECT_THAT(store.SaveFailure(), HasSubstr("limit of 1000"));
  EXPECT_EQ(store.Load(kOtherKey), std::nullopt);
  EXPECT_EQ(store.Load(kKey), "small");
  store.Save(kKey, "again");
  EXPECT_EQ(store.SaveFailure(), "");
}

TEST_F(FileBlobStoreTest, SaysWhyNothingWasKeptWhereTheFolderCannotBe) {
  std::ofstream(folder_ / "file") << "not a folder";
  FileBlobStore store(folder_ / "file" / "cache");
  store.Save(kKey, "bytes");
  EXPECT_THAT(store.SaveFailure(), HasSubstr((folder_ / "file" / "cache").string()));
  EXPECT_EQ(store.Load(kKey), std::nullopt);
}

TEST_F(FileBlobStoreTest, RefusesKeysThatCouldLeadElsewhere) {
  FileBlobStore store = Store();
  for (const std::string key : {"", "../a", "a/b", ".a", "a b"}) {
    EXPECT_THROW(store.Load(key), std::invalid_argument) << key;
    EXPECT_THROW(store.Save(key, "bytes"), std::invalid_argument) << key;
  }
  EXPECT_THROW(store.Load(std::string(129, 'a')), std::invalid_argument);
}

// Gives an environment variable back its value when a test is done with it.
class KeptVariable {
 public:
  explicit KeptVariable(std::string name) : name_(std::move(name)) {
    if (const char* value = std::getenv(name_.c_str())) value_ = value;
  }
  ~KeptVariable() {
    if (value_) {
      setenv(name_.c_str(), value_->c_str(), 1);
    } else {
      unsetenv(name_.c_str());
    }
  }
  KeptVariable(const KeptVariable&) = delete;
  KeptVariable& operator=(const KeptVariable&) = delete;

 private:
  std::string name_;
  std::optional<std::string> value_;
};

TEST(DefaultCacheFolder, FollowsTheUsersCacheVariable) {
  const KeptVariable home("HOME");
  const KeptVariable cache("XDG_CACHE_HOME");
  setenv("HOME", "/home/someone", 1);
  setenv("XDG_CACHE_HOME", "/var/cache/someone", 1);
  EXPECT_EQ(DefaultCacheFolder(), "/var/cache/someone/pleinair");
  EXPECT_EQ(FileBlobStore().Folder(), "/var/cache/someone/pleinair");
  setenv("XDG_CACHE_HOME", "relative", 1);
  EXPECT_EQ(DefaultCacheFolder(), "/home/someone/.cache/pleinair");
  unsetenv("XDG_CACHE_HOME");
  EXPECT_EQ(DefaultCacheFolder(), "/home/someone/.cache/pleinair");
}

}  // namespace
}  // namespace pleinair::file_blob_store_test
