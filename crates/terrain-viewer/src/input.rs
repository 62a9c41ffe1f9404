//! Events become commands and motion. Keys are taken before the interface sees them, unless it is being typed into.

use std::collections::BTreeSet;

use egui::{Context, Event, Key, PointerButton, RawInput};

use crate::camera::Motion;
use crate::command::{Command, KEYS};

/// What flies while it is held.
const HELD: [Key; 10] =
    [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E, Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];

/// The keys that are held, from frame to frame.
#[derive(Default)]
pub struct Keyboard {
    held: BTreeSet<Key>,
    fast: bool,
}

/// What the pointer did over the terrain in one frame, in points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gestures {
    pub drag: [f64; 2],
    /// Notches of the wheel, upwards, and whether Ctrl is held.
    pub wheel: f64,
    pub zooms: bool,
    pub double_click: Option<[f64; 2]>,
}

impl Keyboard {
    /// Takes our keys out of the input, and returns what they ask for.
    pub fn take(&mut self, input: &mut RawInput, is_typed_into: bool) -> Vec<Command> {
        if is_typed_into || !input.focused {
            self.held.clear();
        }
        if is_typed_into {
            return Vec::new();
        }
        let mut commands = Vec::new();
        input.events.retain(|event| match event {
            Event::Key { key, pressed, repeat, modifiers, .. } if !modifiers.ctrl && !modifiers.command => {
                self.take_key(*key, *pressed, *repeat, &mut commands)
            }
            Event::ModifiersChanged(modifiers) => {
                self.fast = modifiers.shift;
                true
            }
            _ => true,
        });
        commands
    }

    /// Whether the key is the interface's.
    fn take_key(&mut self, key: Key, pressed: bool, repeat: bool, commands: &mut Vec<Command>) -> bool {
        if HELD.contains(&key) {
            if pressed {
                self.held.insert(key)
            } else {
                self.held.remove(&key)
            };
            return false;
        }
        let Some(binding) = KEYS.iter().find(|binding| binding.key == key) else { return true };
        if pressed && (!repeat || matches!((binding.command)(), Command::Step(_))) {
            commands.push((binding.command)());
        }
        false
    }

    pub fn motion(&self) -> Motion {
        let axis = |plus: Key, minus: Key| {
            f64::from(u8::from(self.held.contains(&plus))) - f64::from(u8::from(self.held.contains(&minus)))
        };
        Motion {
            forward: axis(Key::W, Key::S),
            right: axis(Key::D, Key::A),
            up: axis(Key::E, Key::Q),
            turn: [axis(Key::ArrowRight, Key::ArrowLeft), axis(Key::ArrowUp, Key::ArrowDown)],
            fast: self.fast,
        }
    }
}

/// What the pointer did outside of the interface; after the interface has had its turn. The wheel is read from the events
/// themselves: the interface smooths it over many frames.
pub fn gestures(context: &Context) -> Gestures {
    if context.egui_wants_pointer_input() {
        return Gestures::default();
    }
    context.input(|input| {
        let pointer = &input.pointer;
        let is_dragged = pointer.primary_down() || pointer.button_down(PointerButton::Secondary);
        let moved = if is_dragged { pointer.delta() } else { egui::Vec2::ZERO };
        let clicked = pointer.button_double_clicked(PointerButton::Primary);
        let at = pointer.interact_pos().filter(|_| clicked);
        Gestures {
            drag: [moved.x.into(), moved.y.into()],
            wheel: input.events.iter().map(notches).sum(),
            zooms: input.modifiers.ctrl,
            double_click: at.map(|at| [at.x.into(), at.y.into()]),
        }
    })
}

fn notches(event: &Event) -> f64 {
    match event {
        Event::MouseWheel { unit: egui::MouseWheelUnit::Point, delta, .. } => f64::from(delta.y) / 50.0,
        Event::MouseWheel { delta, .. } => delta.y.into(),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Default::default() }
    }

    fn input(events: Vec<Event>) -> RawInput {
        RawInput { events, focused: true, ..Default::default() }
    }

    #[test]
    fn held_keys_fly_until_they_are_released_or_the_focus_is_gone() {
        let mut keyboard = Keyboard::default();
        assert!(keyboard.take(&mut input(vec![press(Key::W, true), press(Key::D, true)]), false).is_empty());
        assert_eq!((keyboard.motion().forward, keyboard.motion().right), (1.0, 1.0));
        keyboard.take(&mut input(vec![press(Key::W, false)]), false);
        assert_eq!((keyboard.motion().forward, keyboard.motion().right), (0.0, 1.0));
        keyboard.take(&mut RawInput { focused: false, ..input(Vec::new()) }, false);
        assert_eq!(keyboard.motion(), Motion::default());
    }

    #[test]
    fn tab_is_ours_and_letters_are_the_interfaces_while_it_is_typed_into() {
        let mut keyboard = Keyboard::default();
        let mut raw = input(vec![press(Key::Tab, true), press(Key::Backspace, true)]);
        assert_eq!(keyboard.take(&mut raw, false), [Command::Flip]);
        assert_eq!(raw.events, [press(Key::Backspace, true)]);
        let mut raw = input(vec![press(Key::F, true)]);
        assert!(keyboard.take(&mut raw, true).is_empty());
        assert_eq!(raw.events.len(), 1);
    }
}
