"""Parts that many families share: handles, knobs, buttons, feet, panels."""
