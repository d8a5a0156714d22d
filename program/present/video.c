// SPDX-License-Identifier: MIT
#include "program/present/video.h"

#include "base/io/file.h"
#include "program/present/picture_file.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

bool video_is_folder(const char* path)
{
    struct stat status;
    size_t length = strlen(path);
    return (length > 0 && path[length - 1] == '/') ||
           (stat(path, &status) == 0 && S_ISDIR(status.st_mode));
}

// Starts ffmpeg with the pipe's end as its standard input; what it prints goes to stderr. @return 0
// or an errno
static int spawn_ffmpeg(char* const arguments[], int input, pid_t* child)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE); // ignored here
    sigaddset(&usual, SIGXFSZ);
    int problem = posix_spawn_file_actions_init(&actions);
    if (problem != 0) {
        return problem;
    }
    problem = posix_spawnattr_init(&attributes);
    if (problem == 0) {
        (void)posix_spawnattr_setsigdefault(&attributes, &usual);
        (void)posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
        (void)posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
        (void)posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
        problem = posix_spawnp(child, "ffmpeg", &actions, &attributes, arguments, environ);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&actions);
    return problem;
}

// Creates the file that ffmpeg will write, empty, to find out before a long flight whether it can
// be written.
static bool create_unfinished(video* v)
{
    struct stat status;
    if (stat(v->path, &status) == 0 && !S_ISREG(status.st_mode)) {
        tool_error("%s: is not a regular file", v->path);
        return false;
    }
    stp_file_remove_stale(v->context, v->path);
    if (!stp_file_create_temporary(v->path, v->unfinished, sizeof(v->unfinished))) {
        tool_error("%s: cannot be written: %s", v->path, strerror(errno));
        return false;
    }
    return true;
}

static bool start_film(video* v, uint32_t width, uint32_t height, double fps)
{
    char size[32], rate[32], target[sizeof(v->unfinished) + 8];
    snprintf(size, sizeof(size), "%ux%u", width, height);
    snprintf(rate, sizeof(rate), "%.6f", fps);
    // protects against names with a protocol prefix
    snprintf(target, sizeof(target), "file:%s", v->unfinished);
    // pictures of an odd size get a black line: most films must be even
    const char* words[] = {"ffmpeg",
                           "-loglevel",
                           "error",
                           "-y",
                           "-f",
                           "rawvideo",
                           "-pix_fmt",
                           "rgb24",
                           "-video_size",
                           size,
                           "-framerate",
                           rate,
                           "-i",
                           "pipe:0",
                           "-an",
                           "-vf",
                           "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                           "-pix_fmt",
                           "yuv420p",
                           "-movflags",
                           "+faststart",
                           "-f",
                           "mp4",
                           target,
                           NULL};
    char* arguments[sizeof(words) / sizeof(words[0])];
    memcpy(arguments, words, sizeof(words));
    int ends[2];
    v->row = stp_alloc_array(v->context, width, 3);
    if (v->row == NULL || pipe(ends) != 0) {
        tool_error("%s: cannot create a pipe to ffmpeg: %s", v->path,
                   strerror(v->row == NULL ? ENOMEM : errno));
        return false;
    }
    (void)fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    int problem = spawn_ffmpeg(arguments, ends[0], &v->child);
    close(ends[0]);
    if (problem != 0) {
        close(ends[1]);
        v->child = 0;
        tool_error("%s: ffmpeg, which writes films, cannot be started (%s); install it, or give "
                   "a folder such as -o frames/ for PNG files",
                   v->path, strerror(problem));
        return false;
    }
    v->pipe = ends[1];
    return true;
}

bool video_open(stp_context* context, const char* path, uint32_t width, uint32_t height, double fps,
                video* v)
{
    *v = (video){.context = context, .path = path, .is_folder = video_is_folder(path), .pipe = -1};
    if (!v->is_folder) {
        if (!create_unfinished(v)) {
            return false;
        }
        if (!start_film(v, width, height, fps)) {
            (void)unlink(v->unfinished);
            stp_free(context, v->row);
            return false;
        }
        return true;
    }
    v->made_folder = mkdir(path, 0777) == 0;
    if (!v->made_folder && (errno != EEXIST || !video_is_folder(path))) {
        tool_error("%s: cannot create the folder: %s", path, strerror(errno));
        return false;
    }
    return true;
}

static bool write_whole(int file, const uint8_t* bytes, size_t size)
{
    while (size > 0) {
        ssize_t written = write(file, bytes, size);
        if (written < 0 && errno != EINTR) {
            return false;
        }
        bytes += written > 0 ? written : 0;
        size -= written > 0 ? (size_t)written : 0;
    }
    return true;
}

// Path of a frame's picture in the folder. @return false if the name is too long
static bool name_frame(const video* v, uint32_t frame, char* path, size_t size)
{
    size_t length = strlen(v->path);
    int written = snprintf(path, size, "%s%sframe-%06u.png", v->path,
                           length > 0 && v->path[length - 1] == '/' ? "" : "/", frame);
    return written > 0 && (size_t)written < size;
}

stp_result video_add(void* user, const stp_image* image, uint32_t frame)
{
    video* v = user;
    assert((v->is_folder || (v->child != 0 && v->row != NULL)) && "open and not closed");
    if (v->is_folder) {
        char path[4096];
        v->frame_count = frame + 1;
        return name_frame(v, frame, path, sizeof(path))
                   ? tool_write_picture(v->context, image, path)
                   : stp_fail(v->context, STP_ERROR_IO, "%s: the name is too long", v->path);
    }
    for (uint32_t y = 0; y < image->height; ++y) {
        const uint8_t* pixel = image->pixels + (size_t)y * image->width * 4;
        for (uint32_t x = 0; x < image->width; ++x, pixel += 4) {
            for (uint32_t channel = 0; channel < 3; ++channel) {
                v->row[3 * x + channel] = (uint8_t)((pixel[channel] * pixel[3] + 127) / 255);
            }
        }
        if (!write_whole(v->pipe, v->row, (size_t)image->width * 3)) {
            return stp_fail(v->context, STP_ERROR_IO,
                            "%s: ffmpeg ended before all frames were written", v->path);
        }
    }
    return STP_OK;
}

// Removes the output of an interrupted flight, including the folder if it was created for it.
static void remove_frames(video* v)
{
    char path[4096];
    for (uint32_t frame = 0; frame < v->frame_count; ++frame) {
        if (name_frame(v, frame, path, sizeof(path))) {
            (void)unlink(path);
        }
    }
    if (v->made_folder) {
        (void)rmdir(v->path);
    }
}

bool video_close(video* v, bool whole)
{
    if (v->is_folder && !whole && tool_is_interrupted()) {
        remove_frames(v);
    }
    if (v->child == 0) {
        return true;
    }
    int status = 0;
    close(v->pipe);
    while (waitpid(v->child, &status, 0) < 0 && errno == EINTR) {
    }
    v->child = 0;
    stp_free(v->context, v->row);
    bool good = whole && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    if (whole && !good) {
        tool_error("%s: ffmpeg could not write it (its exit code is %d)", v->path,
                   WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
    } else if (good && rename(v->unfinished, v->path) != 0) {
        tool_error("%s: cannot be written: %s", v->path, strerror(errno));
        good = false;
    }
    if (!good) {
        (void)unlink(v->unfinished);
    }
    return good || !whole;
}
