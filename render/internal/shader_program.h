// A linked pair of shaders, from one source for desktop OpenGL and OpenGL ES.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <epoxy/gl.h>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "render/internal/gl_object.h"

namespace pleinair {

// Sources come without #version and precision lines: those are added for the current context.
class ShaderProgram {
 public:
  // Throws std::runtime_error with `name` and the driver's first complaint.
  ShaderProgram(std::string name, std::string_view vertex, std::string_view fragment);

  void Use() const { glUseProgram(program_.Name()); }

  // Sets a uniform of the program in use. A name that the linker dropped as unused is not an error.
  void Set(const char* uniform, int value) const;
  void Set(const char* uniform, float value) const;
  void Set(const char* uniform, const glm::ivec2& value) const;
  void Set(const char* uniform, const glm::ivec3& value) const;
  void Set(const char* uniform, const glm::ivec4& value) const;
  void Set(const char* uniform, const glm::vec3& value) const;
  void Set(const char* uniform, const glm::vec4& value) const;
  void Set(const char* uniform, const glm::mat4& value) const;
  void SetArray(const char* uniform, std::span<const float> values) const;
  void SetArray(const char* uniform, std::span<const glm::vec2> values) const;
  void SetArray(const char* uniform, const glm::vec3* values, int count) const;

 private:
  GLint Location(const char* uniform) const;

  std::string name_;
  GlObject program_;
};

// A vertex shader for DrawScreen: covers the viewport.
extern const std::string_view kScreenVertexShader;

// Draws one triangle that covers the viewport; needs any vertex array bound.
void DrawScreen();

}  // namespace pleinair
