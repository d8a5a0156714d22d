// SPDX-License-Identifier: MIT
//
// The program's own points: ordered so that every prefix covers the whole evenly, built into a file
// in memory, and drawn.
//
//   cc points.c $(pkg-config --cflags --libs stipple) -lm -o points
//   ./points OUT.ppm [FILE.stip]              with FILE.stip, the file is kept as well
#include <stipple/stipple.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 20000, FEW = 500, SIDE = 480 };

static float positions[3 * COUNT], normals[3 * COUNT];
static uint8_t colors[4 * COUNT];

static void on_log(stp_log_level level, const char* message, void* user)
{
    (void)user;
    fprintf(stderr, "points: %s%s\n", level == STP_LOG_ERROR ? "error: " : "", message);
}

// A torus, its points along a spiral: unordered, a prefix would be a part of it only.
static void make_points(void)
{
    for (int i = 0; i < COUNT; ++i) {
        double a = 6.283185307 * i / COUNT, b = 6.283185307 * (i * 0.618034 - floor(i * 0.618034));
        float* p = positions + 3 * i;
        float* n = normals + 3 * i;
        n[0] = (float)(cos(b) * cos(a));
        n[1] = (float)sin(b);
        n[2] = (float)(cos(b) * sin(a));
        p[0] = (float)(3.0 * cos(a)) + n[0];
        p[1] = n[1];
        p[2] = (float)(3.0 * sin(a)) + n[2];
        colors[4 * i] = (uint8_t)(128.0 + 127.0 * cos(a));
        colors[4 * i + 1] = (uint8_t)(128.0 + 127.0 * sin(a));
        colors[4 * i + 2] = 90;
        colors[4 * i + 3] = 255;
    }
}

// The first points of the order represent all: prints the largest distance of any point to them.
static stp_result order_points(stp_context* context)
{
    static uint32_t order[COUNT];
    float farthest = 0.0f;
    uint32_t ordered = 0;
    stp_result result = stp_order_points(context, NULL, positions, normals, COUNT, FEW, order, NULL,
                                         &ordered, &farthest, NULL);
    if (result == STP_OK) {
        printf("%u of %d points cover all within %.3f; the first are %u, %u, %u\n", ordered, COUNT,
               (double)farthest, order[0], order[1], order[2]);
    }
    return result;
}

static stp_result draw(stp_context* context, const void* bytes, size_t size, stp_image* image)
{
    stp_model* model = NULL;
    stp_painter* painter = NULL;
    stp_hit hit = {.struct_size = sizeof(hit)};
    stp_view view = {.width = SIDE, .height = SIDE};
    stp_model_desc opening = {.bytes = bytes, .size = size, .name = "torus"};
    stp_paint_desc paint = {.splat_size = 2, .background = true};
    stp_result result = stp_model_open(context, &opening, &model);
    result = result == STP_OK ? stp_model_get_view(model, "iso", &view) : result;
    result = result == STP_OK ? stp_painter_create(model, NULL, &painter) : result;
    result = result == STP_OK ? stp_painter_draw(painter, &view, &paint, image, NULL) : result;
    result = result == STP_OK ? stp_model_pick(model, &view, SIDE / 2.0, SIDE * 0.7, &hit) : result;
    if (result == STP_OK && hit.hit) {
        printf("below the middle: a point at %.2f %.2f %.2f, %.2f from the eye\n", hit.position.x,
               hit.position.y, hit.position.z, hit.distance);
    }
    stp_painter_destroy(painter);
    stp_model_close(model);
    return result;
}

static stp_result build_and_draw(stp_context* context, const char* kept, stp_image* image)
{
    stp_builder* builder = NULL;
    stp_builder_desc desc = {.unit_metres = 1.0, .name = "torus"};
    stp_points_desc points = {
        .positions = positions, .normals = normals, .colors = colors, .point_count = COUNT};
    size_t size = 0;
    stp_result result = stp_builder_create(context, &desc, &builder);
    result = result == STP_OK ? stp_builder_add_points(builder, &points, NULL) : result;
    result = result == STP_OK ? stp_builder_write(builder, NULL, NULL) : result; // NULL: to memory
    const void* bytes = result == STP_OK ? stp_builder_get_bytes(builder, &size) : NULL;
    result = result == STP_OK ? draw(context, bytes, size, image) : result;
    FILE* file = result == STP_OK && kept != NULL ? fopen(kept, "wb") : NULL;
    if (file != NULL) {
        fwrite(bytes, 1, size, file);
        fclose(file);
    }
    stp_builder_destroy(builder); // and with it the bytes
    return result;
}

int main(int argc, char** argv)
{
    static uint8_t pixels[4 * SIDE * SIDE];
    stp_image image = {.width = SIDE, .height = SIDE, .pixels = pixels};
    stp_context_desc desc = {.log = on_log};
    stp_context* context;
    if (argc < 2 || stp_context_create(&context, &desc) != STP_OK) {
        fprintf(stderr, "usage: points OUT.ppm [FILE.stip]\n");
        return 2;
    }
    make_points();
    stp_result result = order_points(context);
    result = result == STP_OK ? build_and_draw(context, argv[2], &image) : result;
    stp_context_destroy(context);
    FILE* file = result == STP_OK ? fopen(argv[1], "wb") : NULL;
    if (file == NULL) {
        return 1;
    }
    fprintf(file, "P6\n%d %d\n255\n", SIDE, SIDE);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        fwrite(pixels + 4 * i, 1, 3, file);
    }
    return fclose(file) == 0 ? 0 : 1;
}
