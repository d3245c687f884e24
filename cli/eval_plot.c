#include "eval_plot.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static const char preamble[] = "set encoding utf8\n"
                               "set border 3 lc rgb '" PLOT_INK "' lw 1\n"
                               "set tics nomirror out scale 0.6 textcolor rgb '" PLOT_INK "'\n"
                               "set grid lt 1 lw 1 lc rgb '" PLOT_GRID "'\n"
                               "set key off\n"
                               "set style fill solid 0.18 noborder\n";

fw_status plot_begin(plot *p, int width, int height, const tool *t)
{
	p->script = tmpfile();
	if (p->script == NULL) {
		tool_error(t, "scratch file: %s", strerror(errno));
		return FW_EIO;
	}
	fprintf(p->script, "set terminal svg size %d,%d dynamic font 'sans-serif,13'\n%s", width, height,
	        preamble);
	return FW_OK;
}

/* Runs gnuplot with its three streams on these files. Returns 0, or an errno; *status as waitpid() has it. */
static int run_gnuplot(FILE *script, FILE *svg, FILE *messages, int *status)
{
	static char name[] = "gnuplot", defaults[] = "--default-settings", dash[] = "-";
	char *argv[] = {name, defaults, dash, NULL};
	posix_spawn_file_actions_t files;
	pid_t pid;

	int error = posix_spawn_file_actions_init(&files);
	if (error != 0)
		return error;
	(void)posix_spawn_file_actions_adddup2(&files, fileno(script), STDIN_FILENO);
	(void)posix_spawn_file_actions_adddup2(&files, fileno(svg), STDOUT_FILENO);
	(void)posix_spawn_file_actions_adddup2(&files, fileno(messages), STDERR_FILENO);
	error = posix_spawnp(&pid, name, &files, NULL, argv, environ);
	posix_spawn_file_actions_destroy(&files);
	if (error != 0)
		return error;
	while (waitpid(pid, status, 0) < 0)
		if (errno != EINTR)
			return errno;
	return 0;
}

/* The whole of a file, with a NUL behind it; NULL: no memory, or it could not be read. */
static char *read_back(FILE *f)
{
	if (fseek(f, 0, SEEK_END) != 0)
		return NULL;
	long size = ftell(f);
	char *text = size >= 0 ? malloc((size_t)size + 1) : NULL;
	if (text == NULL)
		return NULL;
	rewind(f);
	text[fread(text, 1, (size_t)size, f)] = '\0';
	return text;
}

/* An element from `begin` on, to the end of its end tag; NULL if there is none. */
static char *skip_element(char *begin, const char *end_tag)
{
	char *end = strstr(begin, end_tag);
	return end != NULL ? end + strlen(end_tag) : NULL;
}

/* From <svg> to </svg>, without what several pictures in one page would have twice (markers nobody uses, identifiers),
 * and without the titles, which a browser would show. */
static void copy_svg(char *svg, FILE *out)
{
	static const struct {
		const char *begin, *end;
	} dropped[] = {
	    {"<defs>", "</defs>"}, {"<title>", "</title>"}, {"<desc>", "</desc>"}, {" id=\"", "\""}};
	enum { N = sizeof dropped / sizeof dropped[0] };

	for (char *p = svg; *p != '\0';) {
		char *after = NULL;
		for (int i = 0; i < N && after == NULL; i++)
			if (strncmp(p, dropped[i].begin, strlen(dropped[i].begin)) == 0)
				after = skip_element(p + strlen(dropped[i].begin), dropped[i].end);
		if (after != NULL)
			p = after;
		else
			fputc(*p++, out);
	}
}

static void complain(const tool *t, int error, const char *messages)
{
	if (error == ENOENT)
		tool_error(t,
		           "--html needs gnuplot, which is not there (Debian: apt-get install gnuplot-nox)");
	else if (error != 0)
		tool_error(t, "gnuplot: %s", strerror(error));
	else
		tool_error(t, "gnuplot failed: %.200s", messages != NULL ? messages : "");
}

static fw_status draw(FILE *script, FILE *svg, FILE *messages, const tool *t, FILE *out)
{
	int status = 0;
	int error = fflush(script) != 0 || ferror(script) ? EIO : 0;
	rewind(script);
	if (error == 0)
		error = run_gnuplot(script, svg, messages, &status);
	char *text = read_back(svg), *said = read_back(messages);
	char *begin = text != NULL ? strstr(text, "<svg") : NULL;
	int good = error == 0 && status == 0 && begin != NULL && strstr(begin, "</svg>") != NULL;
	if (good)
		copy_svg(begin, out);
	else
		complain(t, error, said);
	free(text);
	free(said);
	return good ? FW_OK : FW_EIO;
}

fw_status plot_end(plot *p, const tool *t, FILE *out)
{
	FILE *svg = tmpfile(), *messages = tmpfile();
	fw_status status = FW_EIO;
	if (svg != NULL && messages != NULL)
		status = draw(p->script, svg, messages, t, out);
	else
		tool_error(t, "scratch file: %s", strerror(errno));
	if (svg != NULL)
		fclose(svg);
	if (messages != NULL)
		fclose(messages);
	fclose(p->script);
	return status;
}
