//! The view in a terminal.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, Gauge, GraphType, LegendPosition, Paragraph, Wrap};
use stickslip_shared::predictor::{FingerPrediction, flags};

use crate::plain;
use crate::state::{State, TRACE_S, of_period, used};
use crate::words::{coefficient, doubt_names, flag_names, holds, number, when};

/// Colours of the fingers.
const FINGERS: [Color; 2] = [Color::Cyan, Color::Magenta];
/// From this share of the friction limit on a bar warns.
const HIGH: f32 = 0.8;
/// Narrower terminals have alarms and the line's health above each other, so that alarms can be read.
const WIDE: u16 = 116;
/// Lower terminals have the footer in one line: the course needs the room.
const HIGH_ENOUGH: u16 = 30;
/// End of the course's axis where nothing is above it.
const AXIS: f64 = 1.2;

/// Draws `state` into all of `frame`.
pub fn draw(frame: &mut Frame, state: &State) {
    let short = frame.area().height < HIGH_ENOUGH;
    let [head, fingers, course, below, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(4),
        Constraint::Min(6),
        Constraint::Length(10),
        Constraint::Length(if short { 1 } else { 2 }),
    ])
    .areas(frame.area());
    frame.render_widget(title(state), head);
    let halves: [Rect; 2] = Layout::horizontal([Constraint::Fill(1); 2]).areas(fingers);
    for (number, (area, colour)) in halves.into_iter().zip(FINGERS).enumerate() {
        of_finger(frame, area, number, colour, state);
    }
    trace(frame, course, state);
    let wide = below.width >= WIDE;
    let [object, alarms, line] = if wide {
        Layout::horizontal([Constraint::Length(30), Constraint::Fill(1), Constraint::Length(32)]).areas(below)
    } else {
        let [object, right] = Layout::horizontal([Constraint::Length(30), Constraint::Fill(1)]).areas(below);
        let [alarms, line] = Layout::vertical([Constraint::Fill(1), Constraint::Length(4)]).areas(right);
        [object, alarms, line]
    };
    boxed(frame, object, "object and grip", of_object(state));
    boxed(frame, alarms, &format!("alarms ({})", state.alarms_counted), of_alarms(state, alarms));
    boxed(frame, line, "line", if wide { of_line(state) } else { of_line_briefly(state) });
    frame.render_widget(footer(state, short), foot);
}

fn boxed(frame: &mut Frame, area: Rect, name: &str, lines: Vec<Line<'static>>) {
    let text = Paragraph::new(lines).wrap(Wrap { trim: false });
    frame.render_widget(text.block(Block::bordered().title(name.to_owned())), area);
}

fn title(state: &State) -> Paragraph<'static> {
    let mode = state.mode.map_or(String::new(), |mode| format!("  {mode:?}").to_lowercase());
    let bold = Style::default().add_modifier(Modifier::BOLD);
    let text = vec![
        Span::styled("stickslip", bold),
        Span::raw(format!("  {}{mode}  {:.2} s", state.title, state.now_s)),
    ];
    Paragraph::new(Line::from(text))
}

fn of_finger(frame: &mut Frame, area: Rect, finger: usize, colour: Color, state: &State) {
    let pressed =
        state.wrench(finger).map_or(String::new(), |wrench| format!(", pressed {:.1} N", wrench[1].abs()));
    let block = Block::bordered().title(format!("finger {}{pressed}", finger + 1));
    let Some(prediction) = &state.prediction else {
        frame.render_widget(Paragraph::new("nothing is predicted").block(block), area);
        return;
    };
    let inside = block.inner(area);
    frame.render_widget(block, area);
    let [bar, words] = Layout::vertical([Constraint::Length(1); 2]).areas(inside);
    let f: &FingerPrediction = &prediction.finger[finger];
    let share = used(f);
    let shown = if share.is_finite() { f64::from(share.clamp(0.0, 1.0)) } else { 0.0 };
    let by = if f.measured_utilisation.is_some() { "measured" } else { "model" };
    let slips = prediction.flags & [flags::SLIP_1, flags::SLIP_2][finger] != 0;
    let bar_colour = match share {
        _ if slips => Color::Red,
        share if share >= HIGH => Color::Yellow,
        _ => colour,
    };
    let gauge = Gauge::default().ratio(shown).gauge_style(Style::default().fg(bar_colour));
    let label = match share.is_finite() {
        true => format!("{:.0} % of friction used, {by}", 100.0 * share),
        false => "share of friction not known".to_owned(),
    };
    frame.render_widget(gauge.label(label), bar);
    let text = format!(
        "model {}, ahead {}, slip {}",
        number(f.model_utilisation, 2, ""),
        number(f.peak_utilisation, 2, ""),
        when(f.slip.in_s())
    );
    frame.render_widget(Paragraph::new(text), words);
}

fn trace(frame: &mut Frame, area: Rect, state: &State) {
    let course: [Vec<(f64, f64)>; 2] = [0, 1].map(|finger| {
        let points = state.trace.iter().map(|p| (p.at_s - state.now_s, f64::from(p.used[finger])));
        points.filter(|(_, used)| used.is_finite()).collect()
    });
    // Sensors may show more friction than the model has.
    let most = course.iter().flatten().map(|(_, used)| *used).fold(AXIS, f64::max);
    let end = if most > AXIS { (most / 0.4).ceil().min(5.0) * 0.4 } else { AXIS };
    let course = course.map(|line| line.into_iter().map(|(t, used)| (t, used.min(end))).collect::<Vec<_>>());
    let limit = [(-TRACE_S, 1.0), (0.0, 1.0)];
    let line = |data, colour| {
        Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(Style::default().fg(colour))
            .data(data)
    };
    let [one, two] = &course;
    let sets = vec![
        line(limit.as_slice(), Color::Red),
        line(one.as_slice(), FINGERS[0]).name("finger 1"),
        line(two.as_slice(), FINGERS[1]).name("finger 2"),
    ];
    let chart = Chart::new(sets)
        .block(Block::bordered().title("share of the friction limit; red: slip begins"))
        // The newest is at the right.
        .legend_position(Some(LegendPosition::TopLeft))
        .x_axis(Axis::default().bounds([-TRACE_S, 0.0]).labels([format!("-{TRACE_S:.0} s"), "now".into()]))
        .y_axis(Axis::default().bounds([0.0, end]).labels([
            "0".to_owned(),
            format!("{:.1}", 0.5 * end),
            format!("{end:.1}"),
        ]));
    frame.render_widget(chart, area);
}

fn of_object(state: &State) -> Vec<Line<'static>> {
    let newton = |n: Option<f32>| n.map_or("-".to_owned(), |n| format!("{n:.1} N"));
    let Some(p) = &state.prediction else { return Vec::new() };
    let commanded = state.sample.as_ref().map(|sample| sample.grip_cmd_n);
    let drop = Line::raw(format!("drop          {}", when(p.drop_in_s)));
    let drop = if p.drop_in_s.is_some() { drop.style(Style::default().fg(Color::Red)) } else { drop };
    vec![
        Line::raw(format!("holds         {}", holds(p.hold_probability))),
        Line::raw(format!(
            "sag           {}{}",
            number(p.sag_m * 1e3, 2, " mm"),
            if p.rotation_rad.is_finite() {
                format!(", {:.2}°", p.rotation_rad.to_degrees())
            } else {
                String::new()
            }
        )),
        Line::raw(format!("sag ahead     {}", number(p.sag_ahead_m * 1e3, 2, " mm"))),
        drop,
        Line::raw(format!("grip          {}", newton(commanded))),
        Line::raw(format!("with reserve  {}", newton(p.holding_grip_n))),
        Line::raw(format!("advised       {}", newton(state.advised_grip_n))),
        Line::raw(format!(
            "friction      {}, min {}",
            coefficient(p.friction),
            coefficient(p.friction_least)
        )),
    ]
}

fn of_alarms(state: &State, area: Rect) -> Vec<Line<'static>> {
    let room = usize::from(area.height.saturating_sub(2));
    state
        .alarms
        .iter()
        .rev()
        .take(room)
        .map(|alarm| {
            let colour = if alarm.over_s.is_none() { Color::Red } else { Color::Reset };
            Line::styled(plain::alarm(alarm).trim_start().to_owned(), Style::default().fg(colour))
        })
        .collect()
}

fn of_line(state: &State) -> Vec<Line<'static>> {
    let line = state.line();
    let count = |n: Option<u32>| n.map_or("-".to_owned(), |n| n.to_string());
    let work = |ms: Option<f64>| {
        ms.map_or("-".to_owned(), |ms| format!("{ms:.2} ms, {:.0} %", 100.0 * of_period(ms)))
    };
    vec![
        Line::raw(format!("samples/s      {:.0}", line.samples_per_s)),
        Line::raw(format!("reports/s      {:.0}", line.reports_per_s)),
        Line::raw(format!("reports lost   {}", line.reports_lost)),
        Line::raw(format!("samples lost   {}", count(line.samples_lost))),
        Line::raw(format!("frames damaged {}", line.frames_damaged)),
        Line::raw(format!("tick           {}", work(line.work_ms))),
        Line::raw(format!("worst tick     {}", work(line.work_worst_ms))),
    ]
}

/// In two lines of 48 characters.
fn of_line_briefly(state: &State) -> Vec<Line<'static>> {
    let line = state.line();
    let lost = line.samples_lost.map_or("-".to_owned(), |n| n.to_string());
    let share = |ms: Option<f64>| ms.map_or("-".to_owned(), |ms| format!("{:.0} %", 100.0 * of_period(ms)));
    vec![
        Line::raw(format!(
            "samples/s {:.0}, lost {lost}; reports/s {:.0}, lost {}",
            line.samples_per_s, line.reports_per_s, line.reports_lost
        )),
        Line::raw(format!(
            "damaged {}; tick {} of its time, worst {}",
            line.frames_damaged,
            share(line.work_ms),
            share(line.work_worst_ms)
        )),
    ]
}

fn footer(state: &State, short: bool) -> Paragraph<'static> {
    let said = state.prediction.as_ref().map_or(String::new(), |p| {
        format!("flags: {}   in doubt: {}", flag_names(p.flags), doubt_names(p.validity))
    });
    let last = state.notes.last().map_or(String::new(), |note| format!("   {note}"));
    if short {
        return Paragraph::new(Line::raw(format!("q: quit   {said}{last}")));
    }
    Paragraph::new(vec![Line::raw(said), Line::raw(format!("q: quit{last}"))])
}
