#include "render/internal/composite_pass.h"

#include <initializer_list>
#include <iomanip>
#include <ios>
#include <sstream>
#include <string>
#include <string_view>

#include <glm/common.hpp>
#include <glm/vec4.hpp>

#include "render/internal/composite_shaders.h"
#include "render/real_sun.h"
#include "render/relit_pixel.h"

namespace pleinair {
namespace {

std::string RelightConstants() {
  const auto constant = [](const char* name, float value) {
    std::ostringstream text;
    text << "const float " << name << " = " << std::scientific << std::setprecision(9) << value
         << ";\n";
    return text.str();
  };
  return constant("kSigmaMeasured", kLogSigmaMeasured) +
         constant("kSigmaGuessed", kLogSigmaGuessed) +
         constant("kSharedSigmaMeasured", kSharedLogSigmaMeasured) +
         constant("kSharedSigmaGuessed", kSharedLogSigmaGuessed) +
         constant("kAroundPx", static_cast<float>(kAroundPx)) +
         constant("kOnePlaneCosine", kOnePlaneCosine) + constant("kMeshLogOdds", kMeshLogOdds) +
         constant("kSurelyLit", kSurelyLit) + constant("kSurelySigmas", kSurelySigmas) +
         constant("kLeastHalfBetween", kLeastHalfBetween) + constant("kEvenLeft", kEvenLeft) +
         constant("kLeastEdgeStep", kLeastEdgeStep) + constant("kLeastEdgeShare", kLeastEdgeShare) +
         constant("kTrustedEdgeDistancePx", kTrustedEdgeDistancePx) +
         constant("kLeastRelitChange", kLeastRelitChange) +
         constant("kMostAlbedoSigmas", kMostAlbedoSigmas) + constant("kLeastAlbedo", kLeastAlbedo);
}

std::string Joined(std::initializer_list<std::string_view> parts) {
  std::string whole;
  for (const std::string_view part : parts) whole.append(part);
  return whole;
}

// Binds textures to units in the order given, and unbinds them in the end.
class BoundTextures {
 public:
  explicit BoundTextures(const ShaderProgram& program) : program_(program) {}
  ~BoundTextures() {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + i));
      glBindTexture(targets_[i], 0);
    }
    glActiveTexture(GL_TEXTURE0);
  }
  BoundTextures(const BoundTextures&) = delete;
  BoundTextures& operator=(const BoundTextures&) = delete;

  void Add(const char* uniform, GLuint texture, GLenum target = GL_TEXTURE_2D) {
    glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + targets_.size()));
    glBindTexture(target, texture);
    program_.Set(uniform, static_cast<int>(targets_.size()));
    targets_.push_back(target);
  }

 private:
  const ShaderProgram& program_;
  std::vector<GLenum> targets_;
};

void AddLookup(const LayerLookup& lookup, const ShaderProgram& program, BoundTextures& textures) {
  textures.Add("u_lookup", lookup.IsIdentity() ? 0 : lookup.Texture());
  program.Set("u_has_lookup", lookup.IsIdentity() ? 0 : 1);
}

void AddChange(const RectTexture<glm::vec4>& change,
               const ShaderProgram& program,
               BoundTextures& textures) {
  const PixelRect& rect = change.Rect();
  textures.Add("u_change", change.Texture());
  program.Set("u_change_rect", glm::ivec4(rect.lower, rect.upper - rect.lower));
}

void AddShadow(const CompositeLayers& layers,
               const ShaderProgram& program,
               BoundTextures& textures) {
  textures.Add("u_object_layer", layers.object_layer);
  const PixelRect& rect = layers.hidden_sun.Rect();
  textures.Add("u_shadow_mask", layers.shadow_mask);
  textures.Add("u_hidden_sun", layers.hidden_sun.Texture());
  program.Set("u_hidden_sun_rect", glm::ivec4(rect.lower, rect.upper - rect.lower));
  program.Set("u_blur_reach", layers.shadow_blur.ReachPx());
  program.SetArray("u_blur_weights", layers.shadow_blur.Weights());
}

}  // namespace

PixelRect CompositeLayers::ViewRect(int width, int height) const {
  const PixelRect relit = RelitRect();
  if (relit.Empty()) return relit;
  return {glm::max(relit.lower - kAroundPx, glm::ivec2(0)),
          glm::min(relit.upper + kAroundPx, glm::ivec2(width, height))};
}

CompositePass::CompositePass()
    : target_("composite", GL_RGBA16F, FrameBuffer::DepthStencil::kDepth24Stencil8),
      shadowed_program_("composite: shadowed",
                        kScreenVertexShader,
                        Joined({kLookupShader, kShadowShareShader, kShadowedShader})),
      changed_program_(
          "composite: changed", kScreenVertexShader, Joined({kChangeShader, kChangedShader})),
      cover_program_("composite: cover",
                     kScreenVertexShader,
                     Joined({kLookupShader, kCommonShader, kCoverShader})),
      relight_program_("composite: relight",
                       kScreenVertexShader,
                       Joined({RelightConstants(),
                               kLookupShader,
                               kShadowShareShader,
                               kChangeShader,
                               kCommonShader,
                               kRelightShader})),
      no_vertices_(MakeVertexArray()) {}

// Sets the stencil to 1 where a real pixel may have to be relit.
void CompositePass::MarkRelit(const CompositeLayers& layers) {
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 1, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  if (!layers.ShadowRect().Empty()) {
    ScissorTo(layers.ShadowRect());
    shadowed_program_.Use();
    BoundTextures textures(shadowed_program_);
    AddShadow(layers, shadowed_program_, textures);
    AddLookup(layers.lookup, shadowed_program_, textures);
    DrawScreen();
  }
  if (!layers.change.Rect().Empty()) {
    ScissorTo(layers.change.Rect());
    changed_program_.Use();
    BoundTextures textures(changed_program_);
    AddChange(layers.change, changed_program_, textures);
    DrawScreen();
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glDisable(GL_STENCIL_TEST);
}

void CompositePass::Relight(const CompositeLayers& layers,
                            const CompositeLight& light,
                            float gain) {
  const SurfaceTextures& surface = layers.surface;
  ScissorTo(layers.RelitRect());
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, 1, 0xff);
  relight_program_.Use();
  BoundTextures textures(relight_program_);
  textures.Add("u_camera_radiance", surface.Camera());
  AddShadow(layers, relight_program_, textures);
  textures.Add("u_albedo", surface.Albedo());
  textures.Add("u_normal", surface.Normal());
  textures.Add("u_sky_response", surface.SkyResponse(), GL_TEXTURE_2D_ARRAY);
  textures.Add("u_sun_bounce", surface.SunBounce());
  textures.Add("u_sun_visibility", surface.SunVisibility());
  AddChange(layers.change, relight_program_, textures);
  AddLookup(layers.lookup, relight_program_, textures);
  relight_program_.Set("u_to_sun", glm::vec3(light.to_sun));
  relight_program_.Set("u_sun_irradiance", light.sun_irradiance);
  relight_program_.Set("u_sky_shapes", static_cast<int>(light.sky_irradiance.size()));
  if (!light.sky_irradiance.empty()) {
    relight_program_.SetArray("u_sky_irradiance",
                              light.sky_irradiance.data(),
                              static_cast<int>(light.sky_irradiance.size()));
  }
  relight_program_.Set("u_gain", gain);
  DrawScreen();
}

void CompositePass::Draw(
    const CompositeLayers& layers, const CompositeLight& light, float gain, int width, int height) {
  ResetPassState();
  target_.Resize(width, height);
  target_.Bind();
  ScissorTo(layers.Rect());
  glClear(GL_COLOR_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  glBindVertexArray(no_vertices_.Name());
  const bool has_relit = !layers.RelitRect().Empty();
  if (has_relit) MarkRelit(layers);
  if (!layers.object_rect.Empty()) {
    ScissorTo(layers.object_rect);
    cover_program_.Use();
    BoundTextures textures(cover_program_);
    textures.Add("u_camera_radiance", layers.surface.Camera());
    textures.Add("u_object_layer", layers.object_layer);
    AddLookup(layers.lookup, cover_program_, textures);
    cover_program_.Set("u_gain", gain);
    DrawScreen();
  }
  if (has_relit) Relight(layers, light, gain);
}

}  // namespace pleinair
