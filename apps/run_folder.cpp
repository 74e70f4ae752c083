#include "apps/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/whole_file.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

// Folders of a run with a file or two for each frame, and what else it leaves.
constexpr const char* kFrameFolders[] = {"composite", "mask", "sky", "environment"};
constexpr const char* kRunFiles[] = {
    "lighting.jsonl", "plan.jsonl", "events.jsonl", "report.html", "score.json", "composite.mp4"};
constexpr const char* kLockName = ".pleinair.lock";

// Whether the name is one that WriteWholeFile gives to an unfinished file.
bool IsPartOf(std::string_view name, std::string_view whole) {
  return name.starts_with(".") && name.substr(1).starts_with(whole) && name.ends_with(".part");
}

// NNNNNN..., of a long run with more digits, or an unfinished one of that name.
bool IsOfAFrame(std::string_view name) {
  constexpr std::size_t kDigits = 6;
  const bool is_part = IsPartOf(name, "");
  if (is_part) name.remove_prefix(1);
  const std::size_t digits = name.find_first_not_of("0123456789");
  return digits != std::string_view::npos && digits >= kDigits;
}

bool IsUnfinished(std::string_view name) {
  return name == "composite.partial.mp4" ||
         std::any_of(std::begin(kRunFiles), std::end(kRunFiles), [&](const std::string& whole) {
           return name == whole + ".partial" || IsPartOf(name, whole + ".");
         });
}

// The first result of a run in a folder, relative to it; empty where there is none.
fs::path ResultIn(const fs::path& folder) {
  for (const char* name : kRunFiles) {
    if (fs::exists(folder / name)) return name;
  }
  for (const char* name : kFrameFolders) {
    if (!fs::is_directory(folder / name)) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / name)) {
      const fs::path file = entry.path().filename();
      if (IsOfAFrame(file.string()) && entry.is_regular_file()) return name / file;
    }
  }
  return {};
}

// Each run has this log, from its beginning on.
bool HasLog(const fs::path& folder) {
  return fs::exists(folder / "lighting.jsonl") || fs::exists(folder / "lighting.jsonl.partial");
}

// Returns whether there was one.
template <typename Predicate>
bool RemoveFiles(const fs::path& folder, const Predicate& is_wanted) {
  std::vector<fs::path> wanted;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (is_wanted(entry.path().filename().string()) && entry.is_regular_file()) {
      wanted.push_back(entry.path());
    }
  }
  for (const fs::path& file : wanted) fs::remove(file);
  return !wanted.empty();
}

bool IsIn(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

// Without a slash at the end.
fs::path Canonical(const fs::path& path) {
  const fs::path canonical = fs::weakly_canonical(path);
  return canonical.has_filename() ? canonical : canonical.parent_path();
}

std::string LastError() { return std::generic_category().message(errno); }

std::string ReadAll(int descriptor) {
  std::array<char, 256> buffer{};
  const ssize_t count = pread(descriptor, buffer.data(), buffer.size(), 0);
  std::string text(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  return text.substr(0, text.find('\n'));
}

std::string ThisProcess() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  return fmt::format("process {} on {} since {}", getpid(), host.data(), FormatUtcTime(now));
}

}  // namespace

void RequireApart(const fs::path& out, const fs::path& input) {
  const fs::path read = Canonical(input);
  const auto check = [&](const fs::path& written) {
    const fs::path canonical = Canonical(written);
    if (!IsIn(canonical, read) && !IsIn(read, canonical)) return;
    throw std::invalid_argument(written.string() + ": is, holds or lies in " + input.string() +
                                ", which is only read: expected another folder for results");
  };
  check(out);
  for (const char* name : kFrameFolders) check(out / name);
}

void RequireKept(const fs::path& file, const fs::path& out, const std::string& option) {
  const fs::path read = Canonical(file);
  const fs::path cleared = Canonical(out);
  bool is_removed = false;
  for (const char* name : kRunFiles) is_removed = is_removed || read == cleared / name;
  for (const char* name : kFrameFolders) {
    is_removed = is_removed || read.parent_path() == cleared / name;
  }
  if (!is_removed) return;
  throw std::invalid_argument(option + ": " + file.string() +
                              " is of the run in --out, which is replaced: expected another "
                              "folder for one of them");
}

FolderLock::FolderLock(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  is_made_ = fs::create_directories(folder_, error);
  if (!fs::is_directory(folder_)) {
    throw std::runtime_error("--out " + folder_.string() + ": expected a folder, or room for one" +
                             (error ? ": " + error.message() : ", found something else"));
  }
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(folder_.string() + ": " + why);
  };
  const fs::path file = folder_ / kLockName;
  while (true) {
    file_ = Descriptor(
        open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666));
    if (file_.Number() < 0) refuse("cannot be locked: " + file.string() + ": " + LastError());
    if (flock(file_.Number(), LOCK_EX | LOCK_NB) != 0) {
      const bool is_held = errno == EWOULDBLOCK;
      refuse(is_held ? "another run writes there (" + ReadAll(file_.Number()) +
                           "): expected another --out, or that it has ended"
                     : "cannot be locked: " + LastError());
    }
    // The one who held it may have removed the file before we got it: then it locks nothing.
    struct stat ours {};
    struct stat there {};
    if (fstat(file_.Number(), &ours) == 0 && stat(file.c_str(), &there) == 0 &&
        ours.st_ino == there.st_ino && ours.st_dev == there.st_dev) {
      break;
    }
  }
  try {
    for (const char* name : kRunFiles) RequireReplaceable(folder_ / name);
    for (const char* name : kFrameFolders) {
      const fs::path pictures = folder_ / name;
      if (fs::is_directory(pictures) || !fs::exists(fs::symlink_status(pictures))) continue;
      throw std::runtime_error(pictures.string() +
                               ": expected a folder for pictures, or nothing there");
    }
    const fs::path result = ResultIn(folder_);
    if (!result.empty() && !HasLog(folder_)) {
      refuse("holds " + result.string() + ", but not the lighting.jsonl that each run writes: " +
             "expected an earlier run's folder, or one without such files");
    }
  } catch (...) {
    Remove();
    throw;
  }
  taken_over_from_ = ReadAll(file_.Number());
  const std::string holder = ThisProcess() + "\n";
  // The holder's name in the lock is only information: the lock holds on a full disc, too.
  const bool is_said = ftruncate(file_.Number(), 0) == 0 &&
                       pwrite(file_.Number(), holder.data(), holder.size(), 0) > 0;
  static_cast<void>(is_said);
}

FolderLock::~FolderLock() { Remove(); }

void FolderLock::Remove() {
  std::error_code ignored;
  fs::remove(folder_ / kLockName, ignored);    // While it is still ours.
  if (is_made_) fs::remove(folder_, ignored);  // Only where it is empty.
}

RunFolder::RunFolder(const FolderLock& lock)
    : out_(lock.Folder()),
      had_results_(!ResultIn(out_).empty()),
      had_unfinished_(RemoveFiles(out_, IsUnfinished)) {
  lighting_.emplace(out_ / "lighting.jsonl");
  plan_.emplace(out_ / "plan.jsonl");
}

RunFolder::~RunFolder() {
  if (has_begun_) return;
  // A killed run's pictures have no other log than this to show that they are a run's.
  const bool is_mark = had_results_ && !fs::exists(out_ / "lighting.jsonl");
  if (!is_mark) lighting_->Remove();
  for (std::optional<Log>* log : {&plan_, &events_}) {
    if (*log) (*log)->Remove();
  }
}

void RunFolder::Begin() {
  if (has_begun_) return;
  for (const char* name : kRunFiles) fs::remove(out_ / name);
  for (const char* name : kFrameFolders) {
    if (!fs::is_directory(out_ / name)) continue;
    RemoveFiles(out_ / name, IsOfAFrame);
    if (fs::is_empty(out_ / name)) fs::remove(out_ / name);
  }
  has_begun_ = true;
}

void RunFolder::AddFrame(const std::string& lighting, const std::string& plan) {
  lighting_->Add(lighting);
  try {
    plan_->Add(plan);
  } catch (...) {
    lighting_->RemoveLast();
    throw;
  }
}

void RunFolder::AddEvent(const std::string& line) {
  if (!events_) events_.emplace(out_ / "events.jsonl");
  events_->Add(line);
}

void RunFolder::Finish() {
  Begin();
  if (events_) events_->Finish();
  lighting_->Finish();
  plan_->Finish();
}

RunFolder::Log::Log(fs::path file)
    : file_(std::move(file)), partial_(file_.string() + ".partial"), lines_(partial_) {}

void RunFolder::Log::Finish() { fs::rename(partial_, file_); }

void RunFolder::Log::Remove() {
  std::error_code ignored;
  fs::remove(partial_, ignored);
}

}  // namespace pleinair
