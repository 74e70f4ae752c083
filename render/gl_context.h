// OpenGL contexts without a window. The renderer itself takes any current context.
#pragma once

#include <memory>
#include <string>

namespace pleinair {

enum class GlApi { kDesktop45, kEs31 };

struct GlDescription {
  std::string vendor;
  std::string renderer;
  std::string version;
};

// A surfaceless EGL context, current on the thread that made it until another is made current or it
// is destroyed.
class HeadlessContext {
 public:
  // Throws std::runtime_error, one line: which step failed, with EGL's word for it, and what to
  // install, when no such context can be had.
  explicit HeadlessContext(GlApi api = GlApi::kDesktop45);
  ~HeadlessContext();
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

  // On the thread that made it; does nothing where it is current already. Throws
  // std::runtime_error, one line, where that cannot be.
  void MakeCurrent() const;

  GlDescription Describe() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
