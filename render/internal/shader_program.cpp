#include "render/internal/shader_program.h"

#include <array>
#include <stdexcept>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "render/internal/draw_count.h"

namespace pleinair {

const std::string_view kScreenVertexShader = R"(
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
)";

namespace {

constexpr std::string_view kDesktopHeader = "#version 450 core\n";
constexpr std::string_view kEsHeader =
    "#version 310 es\n"
    "precision highp float;\n"
    "precision highp int;\n"
    "precision highp sampler2D;\n"
    "precision highp sampler2DArray;\n";

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

GlObject Compile(const std::string& name, GLenum stage, std::string_view source) {
  GlObject shader = MakeShader(stage);
  const std::string_view header = epoxy_is_desktop_gl() ? kDesktopHeader : kEsHeader;
  const std::array<const GLchar*, 2> parts{header.data(), source.data()};
  const std::array<GLint, 2> lengths{static_cast<GLint>(header.size()),
                                     static_cast<GLint>(source.size())};
  glShaderSource(shader.Name(), 2, parts.data(), lengths.data());
  glCompileShader(shader.Name());
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.Name(), GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE) {
    std::string log(1024, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(shader.Name(), static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    throw std::runtime_error("shader " + name +
                             (stage == GL_VERTEX_SHADER ? " (vertex)" : " (fragment)") +
                             " does not compile here: " + FirstLine(log));
  }
  return shader;
}

}  // namespace

ShaderProgram::ShaderProgram(std::string name, std::string_view vertex, std::string_view fragment)
    : name_(std::move(name)), program_(MakeProgram()) {
  const GlObject vertex_shader = Compile(name_, GL_VERTEX_SHADER, vertex);
  const GlObject fragment_shader = Compile(name_, GL_FRAGMENT_SHADER, fragment);
  glAttachShader(program_.Name(), vertex_shader.Name());
  glAttachShader(program_.Name(), fragment_shader.Name());
  glLinkProgram(program_.Name());
  GLint linked = GL_FALSE;
  glGetProgramiv(program_.Name(), GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    std::string log(1024, '\0');
    GLsizei length = 0;
    glGetProgramInfoLog(program_.Name(), static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    throw std::runtime_error("shader " + name_ + " does not link here: " + FirstLine(log));
  }
}

GLint ShaderProgram::Location(const char* uniform) const {
  return glGetUniformLocation(program_.Name(), uniform);
}

void ShaderProgram::Set(const char* uniform, int value) const {
  glUniform1i(Location(uniform), value);
}

void ShaderProgram::Set(const char* uniform, float value) const {
  glUniform1f(Location(uniform), value);
}

void ShaderProgram::Set(const char* uniform, const glm::ivec2& value) const {
  glUniform2i(Location(uniform), value.x, value.y);
}

void ShaderProgram::Set(const char* uniform, const glm::ivec3& value) const {
  glUniform3iv(Location(uniform), 1, glm::value_ptr(value));
}

void ShaderProgram::Set(const char* uniform, const glm::ivec4& value) const {
  glUniform4i(Location(uniform), value.x, value.y, value.z, value.w);
}

void ShaderProgram::Set(const char* uniform, const glm::vec3& value) const {
  glUniform3fv(Location(uniform), 1, glm::value_ptr(value));
}

void ShaderProgram::Set(const char* uniform, const glm::vec4& value) const {
  glUniform4fv(Location(uniform), 1, glm::value_ptr(value));
}

void ShaderProgram::Set(const char* uniform, const glm::mat4& value) const {
  glUniformMatrix4fv(Location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}

void ShaderProgram::SetArray(const char* uniform, std::span<const float> values) const {
  glUniform1fv(Location(uniform), static_cast<GLsizei>(values.size()), values.data());
}

void ShaderProgram::SetArray(const char* uniform, std::span<const glm::vec2> values) const {
  glUniform2fv(
      Location(uniform), static_cast<GLsizei>(values.size()), glm::value_ptr(values.front()));
}

void ShaderProgram::SetArray(const char* uniform, const glm::vec3* values, int count) const {
  glUniform3fv(Location(uniform), count, glm::value_ptr(values[0]));
}

void DrawScreen() {
  CountDraw();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace pleinair
