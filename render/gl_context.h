// OpenGL contexts without a window. The renderer itself works with any current context.
#pragma once

#include <memory>
#include <string>

namespace pleinair {

enum class GlApi { kDesktop45, kEs31 };

// The driver's own strings.
struct GlDescription {
  std::string renderer;
  std::string version;
};

// A surfaceless EGL context. It is current on the thread that made it until another is made current
// or it is destroyed.
class HeadlessContext {
 public:
  // Throws std::runtime_error, one line, where no such context is available: the failed step, EGL's
  // error, and what to install.
  explicit HeadlessContext(GlApi api = GlApi::kDesktop45);
  ~HeadlessContext();
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

  // Makes it current, on the thread that made it; does nothing where it is current already. Throws
  // std::runtime_error, one line, where that fails.
  void MakeCurrent() const;

  GlDescription Describe() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
