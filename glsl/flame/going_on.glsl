// Which of the occupied tiles go on with the next stage of repetitions.
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) readonly buffer TileOpen { uint tile_open[]; };

bool goes_on(uint index) {
    if (index >= control.tile_groups.x) {
        return false;
    }
    uint tile = occupied_tiles[index];
    return tile_open[tile] != 0u && tile_repetitions[tile] == stage.done;
}
