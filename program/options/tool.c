// SPDX-License-Identifier: MIT
#include "program/options/tool.h"

#include "base/core/printable.h"
#include "program/options/options.h"
#include "program/options/program.h"
#include "program/options/progress_line.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { INTERRUPTED_CODE = 130 }; // 128 + SIGINT, as shells have it

// Several threads may print messages; a message must not be interrupted by another
// one or by the progress bar.
static pthread_mutex_t output_mutex = PTHREAD_MUTEX_INITIALIZER;
static progress_state progress;
static volatile sig_atomic_t interrupted;
static bool holds_errors;
static char held_error[1024];
static char
    stopped_text[sizeof(held_error)]; ///< the library's message when an interrupt stopped it

tool_settings* tool_settings_get(void)
{
    static tool_settings settings;
    return &settings;
}

bool tool_has_color(FILE* stream)
{
    const char* none = getenv("NO_COLOR");
    const char* terminal = getenv("TERM");
    return isatty(fileno(stream)) && (none == NULL || *none == 0) && terminal != NULL &&
           strcmp(terminal, "dumb") != 0;
}

static char* format_printable(const char* format, va_list list)
    __attribute__((format(printf, 1, 0)));

/// A message safe for a terminal: it contains arguments and file names. NULL if memory runs out; to
/// be freed.
static char* format_printable(const char* format, va_list list)
{
    va_list again;
    va_copy(again, list);
    int length = vsnprintf(NULL, 0, format, again);
    va_end(again);
    size_t size = length > 0 ? (size_t)length + 1 : 1;
    char *message = malloc(size), *shown = malloc(4 * size);
    if (message != NULL && shown != NULL) {
        message[0] = 0;
        vsnprintf(message, size, format, list);
        stp_make_printable(message, shown, 4 * size);
    }
    bool made = message != NULL && shown != NULL;
    free(message);
    if (!made) {
        free(shown);
    }
    return made ? shown : NULL;
}

static void print_message(const char* color, const char* label, const char* format, va_list list)
    __attribute__((format(printf, 3, 0)));

static void print_message(const char* color, const char* label, const char* format, va_list list)
{
    bool colored = *label != 0 && tool_has_color(stderr);
    char* message = format_printable(format, list);
    pthread_mutex_lock(&output_mutex);
    progress_clear(&progress);
    fprintf(stderr, "%s: %s%s%s%s\n", program_get()->name, colored ? color : "", label,
            colored ? "\033[0m" : "", message != NULL ? message : "out of memory");
    pthread_mutex_unlock(&output_mutex);
    free(message);
}

static void print_text(const char* color, const char* label, const char* format, ...)
    __attribute__((format(printf, 3, 4)));

static void print_text(const char* color, const char* label, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    print_message(color, label, format, list);
    va_end(list);
}

int tool_usage_error(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    print_message("", "", format, list);
    va_end(list);
    const char* name = tool_settings_get()->command;
    fprintf(stderr, "Try '%s help%s%s'.\n", program_get()->name, name != NULL ? " " : "",
            name != NULL ? name : "");
    return 2;
}

// A failure after an interrupt is caused by it; tool_finish_interrupted reports that once.
int tool_error(const char* format, ...)
{
    if (interrupted) {
        return 1;
    }
    va_list list;
    va_start(list, format);
    print_message("", "", format, list);
    va_end(list);
    return 1;
}

void tool_hold_errors(void)
{
    assert(!holds_errors && "errors are held once at a time");
    holds_errors = true;
    held_error[0] = 0;
}

const char* tool_held_error(void)
{
    assert(holds_errors && "errors are held");
    return held_error;
}

void tool_release_errors(bool print, const char* more)
{
    assert(holds_errors && "errors were held");
    holds_errors = false;
    if (print && held_error[0] != 0) {
        print_text("", "", "%s%s%s", held_error, more != NULL ? "; " : "",
                   more != NULL ? more : "");
    }
}

static void print_log(stp_log_level level, const char* message, void* user)
{
    (void)user;
    const tool_settings* settings = tool_settings_get();
    char text[sizeof(held_error)];
    option_fields_name(message, text, sizeof(text));
    message = text;
    if (level == STP_LOG_ERROR && interrupted) {
        pthread_mutex_lock(&output_mutex);
        if (stopped_text[0] == 0) {
            snprintf(stopped_text, sizeof(stopped_text), "%s", message);
        }
        pthread_mutex_unlock(&output_mutex);
    } else if (level == STP_LOG_ERROR && holds_errors) {
        pthread_mutex_lock(&output_mutex);
        snprintf(held_error, sizeof(held_error), "%s", message);
        pthread_mutex_unlock(&output_mutex);
    } else if (level == STP_LOG_ERROR) {
        print_text("", "", "%s", message);
    } else if (level == STP_LOG_WARNING && !settings->quiet) {
        print_text("\033[33m", "warning: ", "%s", message);
    } else if (level == STP_LOG_NOTICE && settings->verbose && !settings->quiet) {
        print_text("", "", "%s", message);
    }
}

static int report_progress(const stp_progress_report* report, void* user)
{
    (void)user;
    pthread_mutex_lock(&output_mutex);
    progress_report(&progress, report);
    pthread_mutex_unlock(&output_mutex);
    return interrupted;
}

static void on_interrupt(int signal)
{
    (void)signal;
    interrupted = 1;
}

// The first interrupt ends the work in good order, at its next report of progress; a second one
// kills.
static void catch_interrupt(void)
{
    struct sigaction action = {.sa_handler = on_interrupt,
                               .sa_flags = (int)SA_RESETHAND | SA_RESTART};
    sigemptyset(&action.sa_mask);
    // background jobs of a shell ignore interrupts
    struct sigaction before;
    if (sigaction(SIGINT, NULL, &before) == 0 && before.sa_handler != SIG_IGN) {
        (void)sigaction(SIGINT, &action, NULL);
    }
}

bool tool_is_interrupted(void)
{
    return interrupted != 0;
}

int tool_finish_interrupted(int code, const char* results)
{
    if (!interrupted || code == 0) {
        return code;
    }
    bool stopped = strncmp(stopped_text, "stopped while at: ", 18) == 0;
    print_text("", "", "%s; %s", stopped ? stopped_text : "interrupted",
               results != NULL ? results : "nothing was written");
    return INTERRUPTED_CODE;
}

const char* const tool_progress_names[] = {"auto", "bar", "json", "none"};

stp_context* tool_context_create(uint32_t thread_count, uint64_t memory_limit_bytes,
                                 const char* progress_name)
{
    const tool_settings* settings = tool_settings_get();
    if (!progress_choose(&progress, settings->quiet ? "none" : progress_name, stderr)) {
        tool_usage_error("--progress: '%s' is not one of auto|bar|json|none", progress_name);
        return NULL;
    }
    stp_context_desc desc = {
        .log = print_log,
        .progress = report_progress,
        .thread_count = thread_count,
        .memory_limit_bytes = memory_limit_bytes,
    };
    stp_context* context = NULL;
    stp_result result = stp_context_create(&context, &desc);
    if (result != STP_OK) {
        tool_error("no worker threads: %s", stp_result_string(result));
        return NULL;
    }
    catch_interrupt();
    return context;
}

void tool_end_progress(void)
{
    pthread_mutex_lock(&output_mutex);
    progress_clear(&progress);
    pthread_mutex_unlock(&output_mutex);
}

bool tool_is_same_file(const char* a, const char* b)
{
    struct stat first, second;
    return stat(a, &first) == 0 && stat(b, &second) == 0 && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}

int tool_finish_output(int code)
{
    errno = 0;
    if (fflush(stdout) != 0 || ferror(stdout) != 0) {
        clearerr(stdout);
        return tool_error("standard output: cannot be written: %s",
                          errno != 0 ? strerror(errno) : "the stream is closed");
    }
    return code;
}

/// Writes JSON; escapes non-ASCII characters that a terminal would obey as \\u.
static int write_json(const char* text, size_t size, void* user)
{
    FILE* stream = user;
    while (size > 0) {
        uint32_t code;
        size_t length = 0, plain = stp_find_unprintable(text, size, &code, &length);
        if (fwrite(text, 1, plain, stream) != plain) {
            return -1;
        }
        size_t taken = plain < size ? plain + length : plain;
        if (plain < size && fprintf(stream, "\\u%04x", code) < 0) {
            return -1;
        }
        text += taken;
        size -= taken;
    }
    return 0;
}

static int dump_json(const json_t* object, FILE* stream, size_t flags)
{
    return json_dump_callback(object, write_json, stream, flags);
}

int tool_print_json(json_t* object)
{
    if (object == NULL) {
        return tool_error("out of memory");
    }
    tool_end_progress();
    int failed = dump_json(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(object);
    failed = putc('\n', stdout) == EOF || failed != 0;
    int code = tool_finish_output(0);
    return failed != 0 && code == 0 ? tool_error("standard output: cannot be written") : code;
}
