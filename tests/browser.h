/* browser.h: a headless Chromium that opens one page, for tests: evaluates, moves and clicks the mouse, takes a picture.

   Speaks the DevTools protocol over two pipes (--remote-debugging-pipe: messages of JSON that end in a zero byte; the
   browser reads descriptor 3 and writes descriptor 4), so that no port is opened. The few replies needed are found in the
   text. POSIX. */
#ifndef TESTS_BROWSER_H
#define TESTS_BROWSER_H

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct browser {
    pid_t process;
    int to, from; /* pipes */
    int id;       /* of the last message */
    char session[128];
    char *reply;  /* the last one */
    size_t size;
} browser;

static const char *browser_program(void)
{
    static const char *const names[] = { "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome" };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (access(names[i], X_OK) == 0)
            return names[i];
    return NULL;
}

static void browser_exec(const char *program, const char *folder, int in, int out)
{
    char profile[512];
    snprintf(profile, sizeof profile, "--user-data-dir=%s/profile", folder);
    int spare_in = dup(in), spare_out = dup(out); /* neither is 3 or 4 any more when these are taken */
    dup2(spare_in, 10);
    dup2(spare_out, 11);
    dup2(10, 3);
    dup2(11, 4);
    if (!freopen("/dev/null", "w", stderr))
        _exit(126);
    execl(program, program, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--window-size=1280,1000",
          "--remote-debugging-pipe", profile, (char *)NULL);
    _exit(127);
}

/* The text between `before` and the next quote of the last reply; "" if absent. */
static void browser_pick(const browser *b, const char *before, char *out, size_t size)
{
    const char *at = b->reply ? strstr(b->reply, before) : NULL;
    out[0] = 0;
    if (!at)
        return;
    at += strlen(before);
    snprintf(out, size, "%.*s", (int)strcspn(at, "\""), at);
}

/* Reads one message into b->reply. */
static bool browser_read(browser *b)
{
    size_t n = 0;
    for (;;) {
        if (n + 65536 > b->size) {
            b->size = n + 65536;
            b->reply = realloc(b->reply, b->size);
        }
        ssize_t got = read(b->from, b->reply + n, 1); /* the next message must stay in the pipe */
        if (got <= 0)
            return false;
        if (!b->reply[n++])
            return true;
    }
}

/* Sends a command and waits for its reply; events in between are dropped. */
static bool browser_call(browser *b, const char *method, const char *params)
{
    char message[4096], mark[32];
    int length = snprintf(message, sizeof message, "{\"id\":%d,%s%s%s\"method\":\"%s\",\"params\":%s}", ++b->id, b->session[0] ? "\"sessionId\":\"" : "",
                          b->session, b->session[0] ? "\"," : "", method, params);
    if (length >= (int)sizeof message || write(b->to, message, (size_t)length + 1) != length + 1)
        return false;
    snprintf(mark, sizeof mark, "{\"id\":%d,", b->id);
    while (browser_read(b))
        if (!strncmp(b->reply, mark, strlen(mark)))
            return !strstr(b->reply, "\"error\":{");
    return false;
}

/* Result of a JavaScript expression that gives a string without quotes; "" on failure. */
static void browser_evaluate(browser *b, const char *expression, char *out, size_t size)
{
    char params[2048];
    snprintf(params, sizeof params, "{\"expression\":\"%s\",\"returnByValue\":true}", expression);
    out[0] = 0;
    if (browser_call(b, "Runtime.evaluate", params))
        browser_pick(b, "\"value\":\"", out, size);
}

static bool browser_mouse(browser *b, const char *type, double x, double y)
{
    char params[256];
    snprintf(params, sizeof params, "{\"type\":\"%s\",\"x\":%g,\"y\":%g,\"button\":\"%s\",\"clickCount\":1}", type, x, y,
             strcmp(type, "mouseMoved") ? "left" : "none");
    return browser_call(b, "Input.dispatchMouseEvent", params);
}

static bool browser_click(browser *b, double x, double y)
{
    return browser_mouse(b, "mouseMoved", x, y) && browser_mouse(b, "mousePressed", x, y) && browser_mouse(b, "mouseReleased", x, y);
}

static bool browser_attach(browser *b, const char *path)
{
    char params[1024], target[128], state[32] = "";
    snprintf(params, sizeof params, "{\"url\":\"file://%s\"}", path);
    if (!browser_call(b, "Target.createTarget", params))
        return false;
    browser_pick(b, "\"targetId\":\"", target, sizeof target);
    snprintf(params, sizeof params, "{\"targetId\":\"%s\",\"flatten\":true}", target);
    if (!browser_call(b, "Target.attachToTarget", params))
        return false;
    browser_pick(b, "\"sessionId\":\"", b->session, sizeof b->session);
    for (int i = 0; i < 100 && strcmp(state, "complete"); i++) {
        usleep(100000);
        browser_evaluate(b, "location.protocol === 'file:' ? document.readyState : ''", state, sizeof state); /* the empty page before it is complete too */
    }
    return !strcmp(state, "complete");
}

/* Opens a page; the profile goes to `folder`. */
static bool browser_open(browser *b, const char *program, const char *folder, const char *path)
{
    int to[2], from[2];
    memset(b, 0, sizeof *b);
    if (pipe(to) || pipe(from))
        return false;
    signal(SIGPIPE, SIG_IGN);
    b->process = fork();
    if (b->process == 0)
        browser_exec(program, folder, to[0], from[1]);
    close(to[0]);
    close(from[1]);
    b->to = to[1];
    b->from = from[0];
    return b->process > 0 && browser_attach(b, path);
}

static void browser_close(browser *b)
{
    b->session[0] = 0;
    browser_call(b, "Browser.close", "{}");
    close(b->to);
    close(b->from);
    if (b->process > 0)
        waitpid(b->process, NULL, 0);
    free(b->reply);
}

#endif
