#include "render/internal/volume_stencil.h"

namespace pleinair {

const std::string_view kPositionVertexShader = R"(
layout(location = 0) in vec4 a_position;
uniform mat4 u_clip_from_local;
uniform vec4 u_clip_of_infinity;
invariant gl_Position;
void main() {
  gl_Position = a_position.w == 0.0 ? u_clip_of_infinity : u_clip_from_local * a_position;
}
)";

namespace {

constexpr std::string_view kNothingFragmentShader = "void main() {}\n";

constexpr GLuint kCountBits = 0x7f;
constexpr GLuint kShadowBit = 0x80;

}  // namespace

VolumeStencil::VolumeStencil()
    : position_program_("position", kPositionVertexShader, kNothingFragmentShader),
      screen_program_("fold", kScreenVertexShader, kNothingFragmentShader),
      no_vertices_(MakeVertexArray()) {}

void VolumeStencil::DrawSurface(const CasterBuffers& caster,
                                const glm::mat4& clip_from_local) const {
  position_program_.Use();
  position_program_.Set("u_clip_from_local", clip_from_local);
  position_program_.Set("u_clip_of_infinity", glm::vec4(0.0f));
  caster.DrawSurface(clip_from_local);
}

void VolumeStencil::Begin(const glm::mat4& clip_from_local, const glm::vec4& clip_of_infinity) {
  clip_from_local_ = clip_from_local;
  clip_of_infinity_ = clip_of_infinity;
  depth_so_far_ = 0;
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_STENCIL_TEST);
}

void VolumeStencil::Draw(const CasterBuffers& caster, const ShadowVolumes& volumes, Caps caps) {
  for (const ShadowVolumes::Batch& batch : volumes.batches) {
    if (depth_so_far_ + batch.depth_bound > ShadowVolumes::kMaxBatchDepth) Fold();
    depth_so_far_ += batch.depth_bound;
    position_program_.Use();
    position_program_.Set("u_clip_from_local", clip_from_local_);
    position_program_.Set("u_clip_of_infinity", clip_of_infinity_);
    glStencilMask(kCountBits);
    glStencilFunc(GL_ALWAYS, 0, kCountBits);
    glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_DECR_WRAP, GL_KEEP);
    glStencilOpSeparate(GL_BACK, GL_KEEP, GL_INCR_WRAP, GL_KEEP);
    glDepthFunc(GL_LESS);
    caster.DrawSides(batch);
    if (caps == Caps::kNeverInFront) glDepthFunc(GL_NEVER);
    caster.DrawCaps(batch);
  }
}

void VolumeStencil::Fold() {
  screen_program_.Use();
  glBindVertexArray(no_vertices_.Name());
  glDepthFunc(GL_ALWAYS);
  glStencilMask(0xff);
  // Where the count is not 0: keep the shadow, begin the count again.
  glStencilFunc(GL_NOTEQUAL, static_cast<GLint>(kShadowBit), kCountBits);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  DrawScreen();
  depth_so_far_ = 0;
}

void VolumeStencil::Finish() {
  glStencilMask(0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glStencilFunc(GL_ALWAYS, 0, 0xff);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

}  // namespace pleinair
