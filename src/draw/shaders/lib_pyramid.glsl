// Layout of the depth pyramid: consecutive levels of rows of blocks.

ivec2 count_blocks(ivec2 size, int level)
{
    int shift = PYRAMID_SHIFT + level;
    return (size + (1 << shift) - 1) >> shift;
}

int find_level(ivec2 size, int level)
{
    int offset = 0;
    for (int i = 0; i < level; ++i) {
        ivec2 blocks = count_blocks(size, i);
        offset += blocks.x * blocks.y;
    }
    return offset;
}
