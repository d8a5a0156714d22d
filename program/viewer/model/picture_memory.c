// SPDX-License-Identifier: MIT
#include "program/viewer/model/picture_memory.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

bool picture_memory_fit(painter_picture* picture, uint32_t width, uint32_t height)
{
    size_t needed = (size_t)width * height;
    if (needed > picture->capacity) {
        picture_memory_free(picture);
        picture->image.pixels = malloc(needed * 4);
        picture->nearness = malloc(needed * sizeof(float));
        if (picture->image.pixels == NULL || picture->nearness == NULL) {
            return false;
        }
        picture->capacity = needed;
    }
    picture->image.width = width;
    picture->image.height = height;
    return true;
}

void picture_memory_copy_depth(painter_picture* picture, const float* nearness)
{
    size_t count = (size_t)picture->image.width * picture->image.height, pixel = 0;
    assert(count <= picture->capacity);
    if (nearness != NULL) {
        memcpy(picture->nearness, nearness, count * sizeof(float));
    } else {
        memset(picture->nearness, 0, count * sizeof(float));
    }
    while (pixel < count && !(picture->nearness[pixel] > 0.0f)) {
        pixel += 1;
    }
    picture->is_empty = nearness != NULL && pixel == count;
}

void picture_memory_free(painter_picture* picture)
{
    free(picture->image.pixels);
    free(picture->nearness);
    picture->image.pixels = NULL;
    picture->nearness = NULL;
    picture->capacity = 0;
}
