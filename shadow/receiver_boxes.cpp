#include "shadow/receiver_boxes.h"

#include "core/base/parallel.h"

namespace relume {

std::vector<Bounds> receiver_boxes(const ViewReceivers& view) {
  std::vector<Bounds> boxes(view.tile_count());
  parallel_for(boxes.size(), 4, [&](size_t begin, size_t end) {
    for (size_t tile = begin; tile < end; ++tile) {
      view.visit_tile(tile, [&](const ReceiverGroup& group) {
        const Receivers& receivers = group.receivers;
        for (int i = 0; i < receivers.count; ++i) {
          if (!(receivers.weight[i] > 0)) continue;
          boxes[tile].extend(
              vec3(receivers.position[0][i], receivers.position[1][i], receivers.position[2][i]));
        }
      });
    }
  });
  std::erase_if(boxes, [](const Bounds& box) { return box.empty(); });
  return boxes;
}

}  // namespace relume
