// SPDX-License-Identifier: MIT
//
// A picture from a file: opens FILE.stip, frames it, draws it with the CPU, and writes a PPM.
//
//   cc picture.c $(pkg-config --cflags --libs stipple) -o picture
//   ./picture FILE.stip OUT.ppm [VIEW]        VIEW: iso (default), front, top, ..., or a view of
// the file
#include <stipple/stipple.h>

#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 640, HEIGHT = 480 };

static void on_log(stp_log_level level, const char* message, void* user)
{
    static const char* const levels[] = {"error", "warning", "notice"};
    (void)user;
    fprintf(stderr, "picture: %s: %s\n", levels[level], message);
}

static int write_ppm(const stp_image* image, const char* path)
{
    FILE* file = fopen(path, "wb");
    if (file == NULL) {
        perror(path);
        return 0;
    }
    fprintf(file, "P6\n%u %u\n255\n", image->width, image->height);
    for (size_t i = 0; i < (size_t)image->width * image->height; ++i) {
        fwrite(image->pixels + 4 * i, 1, 3, file); // red, green, blue; not alpha
    }
    return fclose(file) == 0;
}

// Opens and draws. Frees everything it created, also after a failure.
static stp_result draw(stp_context* context, const char* path, const char* view_name,
                       stp_image* image)
{
    stp_model* model = NULL;
    stp_painter* painter = NULL;
    stp_model_desc opening = {.path = path};
    stp_model_info info = {.struct_size = sizeof(info)};
    stp_view view = {.width = image->width, .height = image->height};
    stp_paint_desc paint = {.samples = 2, .background = true, .background_color = {255, 255, 255}};
    stp_paint_report report = {.struct_size = sizeof(report)};

    stp_result result = stp_model_open(context, &opening, &model);
    if (result == STP_OK) {
        result = stp_model_get_info(model, &info);
    }
    if (result == STP_OK) {
        result = stp_model_get_view(model, view_name, &view);
    }
    if (result == STP_OK) {
        result = stp_painter_create(model, NULL, &painter); // NULL: the CPU draws
    }
    if (result == STP_OK) {
        result = stp_painter_draw(painter, &view, &paint, image, &report);
    }
    if (result == STP_OK) {
        printf("%llu triangles, drawn by %llu splats and %llu triangles in %.1f ms\n",
               (unsigned long long)info.triangle_count, (unsigned long long)report.splat_count,
               (unsigned long long)report.triangle_count, report.frame_ms);
    }
    stp_painter_destroy(painter);
    stp_model_close(model);
    return result;
}

int main(int argc, char** argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: picture FILE.stip OUT.ppm [VIEW]\n");
        return 2;
    }
    stp_context* context;
    stp_context_desc desc = {.log = on_log};
    if (stp_context_create(&context, &desc) != STP_OK) {
        return 1;
    }
    stp_image image = {.width = WIDTH, .height = HEIGHT, .pixels = malloc(4 * WIDTH * HEIGHT)};
    int written = image.pixels != NULL &&
                  draw(context, argv[1], argc > 3 ? argv[3] : NULL, &image) == STP_OK &&
                  write_ppm(&image, argv[2]);
    free(image.pixels);
    stp_context_destroy(context);
    return written ? 0 : 1;
}
