#include "core/shade/shaders.h"

#include "core/shade/shader_list.h"

namespace relume {
namespace {

template <class... Shaders>
constexpr std::array<const ShaderInfo*, sizeof...(Shaders)> make_table(ShaderList<Shaders...>) {
  return {&Shaders::info...};
}

constexpr auto table = make_table(AllShaders{});

}  // namespace

std::span<const ShaderInfo* const> shader_table() {
  return table;
}

}  // namespace relume
