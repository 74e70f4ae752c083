#include "render/internal/device_timer.h"

namespace pleinair {
namespace {

GLuint64 NanosecondsOf(const GlObject& query) {
  GLuint64 time_ns = 0;
  glGetQueryObjectui64v(query.Name(), GL_QUERY_RESULT, &time_ns);
  return time_ns;
}

}  // namespace

DeviceTimer::DeviceTimer() {
  if (!epoxy_is_desktop_gl()) return;
  GLint bits = 0;
  glGetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
  if (bits < 1) return;
  // A device's counter may have fewer bits than its result.
  if (bits < 64) mask_ = (GLuint64{1} << bits) - 1;
  start_ = MakeQuery();
  stop_ = MakeQuery();
}

void DeviceTimer::Start() {
  if (start_) glQueryCounter(start_.Name(), GL_TIMESTAMP);
}

void DeviceTimer::Stop() {
  if (stop_) glQueryCounter(stop_.Name(), GL_TIMESTAMP);
}

double DeviceTimer::Ms() const {
  if (!start_) return 0.0;
  return 1e-6 * static_cast<double>((NanosecondsOf(stop_) - NanosecondsOf(start_)) & mask_);
}

}  // namespace pleinair
